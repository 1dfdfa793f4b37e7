"""host/gravcomp_motion.c as a shared library, with the methods of its Python twin."""

import ctypes
import subprocess
from dataclasses import fields
from pathlib import Path

from c_host import READ, STRICT, WRITE, CBus, CIdentity
from codes import ROOT
from gravcomp.driver.host import MAX_AXES, Bus, Result
from gravcomp.driver.motion import MotionSettings, MotionState, RecordStatus
from gravcomp.twin.recorder import Mode, words_of

_U8, _U32, _I32 = ctypes.c_uint8, ctypes.c_uint32, ctypes.c_int32


class CSettings(ctypes.Structure):
    """gravcomp_motion_settings."""

    _fields_ = tuple((f.name, _U32 if f.type is int else _U32 * MAX_AXES) for f in fields(MotionSettings))


class CState(ctypes.Structure):
    """gravcomp_motion_state."""

    _fields_ = tuple((f.name, _I32 * MAX_AXES if f.type == tuple[int, ...] else _U8) for f in fields(MotionState))


class CStatus(ctypes.Structure):
    """gravcomp_record_status."""

    _fields_ = tuple((f.name, _U32) for f in fields(RecordStatus))


def compile_motion(folder: Path) -> Path:
    """Compile the driver, every warning an error, to a shared library in folder."""
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / "libgravcomp_motion.so"
    subprocess.run(["cc", *STRICT, "-shared", "-fPIC", "-o", library, ROOT / "host" / "gravcomp_motion.c"], check=True)
    return library


class CMotion:
    """gravcomp.driver.motion.Motion, computed by the C driver."""

    def __init__(self, library: Path, bus: Bus, axes: int):
        self._c, self._axes = ctypes.CDLL(str(library)), axes
        self._callbacks = READ(lambda _, offset: bus.read(offset)), WRITE(lambda _, o, word: bus.write(o, word))
        self._bus, self._identity, self._taken = CBus(*self._callbacks, None), CIdentity(axes=axes), _U32()

    def configure(self, settings: MotionSettings) -> None:
        values = {n: (_U32 * MAX_AXES)(*v) if isinstance(v, tuple) else v for n, v in vars(settings).items()}
        self._call("motion_configure", ctypes.byref(self._identity), ctypes.byref(CSettings(**values)))

    def move(self, target: tuple[int, ...], ticks: int, polls: int) -> Result:
        counts = (_I32 * MAX_AXES)(*target)
        return Result(self._call("move", ctypes.byref(self._identity), counts, _U32(ticks), _U32(polls)))

    def read(self) -> MotionState:
        state = CState()
        self._call("motion_read", ctypes.byref(self._identity), ctypes.byref(state))
        values = {name: getattr(state, name) for name, _ in CState._fields_}
        return MotionState(**{n: v if isinstance(v, int) else tuple(v)[: self._axes] for n, v in values.items()})

    def record(self, mode: Mode, polls: int, *, mean: bool = False, ticks: int = 0, before: int = 0) -> Result:
        numbers = (ctypes.c_int(mode), ctypes.c_bool(mean), _U32(ticks), _U32(before), _U32(polls))
        return Result(self._call("record", *numbers, ctypes.byref(self._taken)))

    def record_status(self) -> RecordStatus:
        status = CStatus()
        self._call("record_read_status", ctypes.byref(status))
        return RecordStatus(**{name: getattr(status, name) for name, _ in CStatus._fields_})

    def take(self, most: int) -> list[int]:
        words = (_U32 * (most * words_of(self._axes)))()
        n = self._call("take_records", ctypes.byref(self._identity), ctypes.byref(self._taken), words, _U32(most))
        return list(words[: n * words_of(self._axes)])

    def _call(self, name: str, *arguments) -> int:
        return getattr(self._c, f"gravcomp_{name}")(ctypes.byref(self._bus), *arguments)
