"""host/gravcomp.c as a shared library, with the methods of its Python twin."""

import ctypes
import subprocess
from dataclasses import fields
from pathlib import Path

from codes import ROOT
from gravcomp.driver.host import MAX_AXES, Bus, Identity, Result, Settings, State

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
SOURCES = ("gravcomp.c", "example.c")
MACHINE = ROOT / "rtl" / "generated"  # gravcomp_machine.h

READ = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_void_p, ctypes.c_uint32)
WRITE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32)


class CBus(ctypes.Structure):
    """gravcomp_bus."""

    _fields_ = (("read", READ), ("write", WRITE), ("context", ctypes.c_void_p))


def _struct(name: str, twin: type, arrays: dict, types: dict, default: type) -> type:
    """The C struct with the fields of a dataclass, in their order."""
    members = []
    for field in fields(twin):
        kind = types.get(field.name, default)
        members.append((field.name, kind * arrays[field.name] if field.name in arrays else kind))
    return type(name, (ctypes.Structure,), {"_fields_": members})


def _per_axis(twin: type) -> dict[str, int]:
    return {field.name: MAX_AXES for field in fields(twin) if field.type == tuple[int, ...]}


_U8, _U32, _I32 = ctypes.c_uint8, ctypes.c_uint32, ctypes.c_int32
_AXES = _per_axis(State)
_WORDS = ("result_number", "missed_ticks", "cause", "fault", "first_cause")
CState = _struct("CState", State, _AXES, dict.fromkeys(_AXES, _I32) | dict.fromkeys(_WORDS, _U32), _U8)
CSettings = _struct("CSettings", Settings, _per_axis(Settings), {"index_position": _I32}, _U32)
CIdentity = _struct(
    "CIdentity",
    Identity,
    _per_axis(Identity) | {"weights_hash": 8, "compensation_hash": 8},
    {"axes": _U8, "hidden": _U8, "lanes": _U8, "lean": ctypes.c_bool, "trained_low": _I32, "trained_high": _I32},
    _U32,
)


def compile_host(folder: Path, *options: str, machine: Path = MACHINE) -> Path:
    """Compile driver and example, with the header in machine, every warning an error, to a shared library in folder."""
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / "libgravcomp.so"
    sources = [ROOT / "host" / name for name in SOURCES]
    subprocess.run(["cc", *STRICT, f"-I{machine}", *options, "-shared", "-fPIC", "-o", library, *sources], check=True)
    return library


def _plain(struct: ctypes.Structure, twin: type, axes: int):
    """The dataclass with the values of its struct, those of the axes that are there."""
    values = {name: getattr(struct, name) for name, *_ in struct._fields_}
    return twin(**{
        name: tuple(value)[: None if name.endswith("_hash") else axes] if isinstance(value, ctypes.Array) else value
        for name, value in values.items()
    })  # fmt: skip


def _filled(struct: type, values: Identity | Settings) -> ctypes.Structure:
    """The struct with the values of its dataclass."""
    kinds = dict(struct._fields_)
    fields_c = {name: kinds[name](*v) if isinstance(v, tuple) else v for name, v in vars(values).items()}
    return struct(**fields_c)


class CHost:
    """gravcomp.driver.host.Host, computed by the C driver."""

    def __init__(self, library: Path, bus: Bus):
        self._c = ctypes.CDLL(str(library))
        # Kept: ctypes forgets callbacks that nothing refers to.
        self._callbacks = READ(lambda _, offset: bus.read(offset)), WRITE(lambda _, o, word: bus.write(o, word))
        self._bus = CBus(*self._callbacks, None)
        self._identity = CIdentity()  # of the last open

    def open(self) -> tuple[Result, Identity | None]:
        result = self._call("open", ctypes.byref(self._identity))
        return result, _plain(self._identity, Identity, self._identity.axes) if result == Result.OK else None

    def complaint(self, identity: Identity, settings: Settings) -> str | None:
        function = self._c.gravcomp_complaint
        function.restype = ctypes.c_char_p
        line = function(ctypes.byref(_filled(CIdentity, identity)), ctypes.byref(_filled(CSettings, settings)))
        return line.decode() if line else None

    def configure(self, identity: Identity, settings: Settings) -> Result:
        return self._call(
            "configure", ctypes.byref(_filled(CIdentity, identity)), ctypes.byref(_filled(CSettings, settings))
        )

    def home(self, axes: int) -> Result:
        return self._call("home", ctypes.c_uint8(axes))

    def start(self) -> None:
        self._c.gravcomp_start(ctypes.byref(self._bus))

    def tick(self, is_on: bool) -> Result:
        return self._call("tick", ctypes.c_bool(is_on))

    def wait(self, number: int, polls: int) -> Result:
        return self._call("wait", _U32(number), _U32(polls))

    def release(self, polls: int) -> Result:
        return self._call("release", _U32(polls))

    def stop(self) -> Result:
        return self._call("stop")

    def kick(self) -> None:
        self._c.gravcomp_kick(ctypes.byref(self._bus))

    def clear_faults(self, faults: int) -> None:
        self._c.gravcomp_clear_faults(ctypes.byref(self._bus), _U32(faults))

    def core_runs(self) -> bool:
        self._c.gravcomp_core_runs.restype = ctypes.c_bool
        return self._c.gravcomp_core_runs(ctypes.byref(self._bus))

    def brakes_fed(self) -> int:
        self._c.gravcomp_brakes_fed.restype = _U8
        return self._c.gravcomp_brakes_fed(ctypes.byref(self._bus))

    def clear_encoders(self) -> None:
        self._c.gravcomp_clear_encoders(ctypes.byref(self._bus))

    def read(self) -> State:
        state = CState()
        self._c.gravcomp_read(ctypes.byref(self._bus), ctypes.byref(self._identity), ctypes.byref(state))
        return _plain(state, State, self._identity.axes)

    def crc32(self, image: bytes) -> int:
        function = self._c.gravcomp_crc32
        function.restype = _U32
        return function(image, _U32(len(image) // 4))

    def load(self, image: bytes, crc: int, polls: int) -> Result:
        return self._call("load", image, _U32(len(image) // 4), _U32(crc), _U32(polls))

    def use_rom(self, polls: int) -> Result:
        return self._call("use_rom", _U32(polls))

    def bank_crc(self) -> int:
        function = self._c.gravcomp_bank_crc
        function.restype = _U32
        return function(ctypes.byref(self._bus))

    def interrupt_on(self, events: int) -> None:
        self._c.gravcomp_interrupt_on(ctypes.byref(self._bus), _U32(events))

    def interrupts(self) -> int:
        function = self._c.gravcomp_interrupts
        function.restype = _U32
        return function(ctypes.byref(self._bus))

    def run_example(self, image: bytes, n_results: int) -> int:
        """host/example.c on this bus: its exit code; it prints to the C library's standard output."""
        n_words = _U32(len(image) // 4)
        code = self._c.run_example(ctypes.byref(self._bus), image, n_words, ctypes.c_int(n_results))
        self._c.fflush(None)
        return code

    def _call(self, name: str, *arguments) -> Result:
        return Result(getattr(self._c, f"gravcomp_{name}")(ctypes.byref(self._bus), *arguments))
