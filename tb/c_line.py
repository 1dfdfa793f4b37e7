"""host/gravcomp_modbus.c as a shared library, between gravcomp.c and a line of this process."""

import ctypes
import subprocess
from collections.abc import Callable
from enum import IntEnum
from pathlib import Path

from c_host import MACHINE, STRICT, CBus
from codes import ROOT

SOURCES = ("gravcomp.c", "gravcomp_modbus.c")
SEND = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.POINTER(ctypes.c_uint8), ctypes.c_uint32)
RECEIVE = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_void_p, ctypes.POINTER(ctypes.c_uint8), ctypes.c_uint32)


class LineResult(IntEnum):
    """gravcomp_line_result."""

    OK = 0
    SILENT = 1
    DAMAGED = 2
    REFUSED = 3


class CLine(ctypes.Structure):
    """gravcomp_line."""

    _fields_ = (
        ("send", SEND), ("receive", RECEIVE), ("context", ctypes.c_void_p), ("unit", ctypes.c_uint8),
        ("attempts", ctypes.c_uint32), ("first", ctypes.c_int), ("exception", ctypes.c_uint8),
        ("repeated", ctypes.c_uint32), ("written", ctypes.c_uint32),
        ("is_counted", ctypes.c_bool),
    )  # fmt: skip


def compile_line(folder: Path) -> Path:
    """Compile both drivers, every warning an error, to a shared library in folder."""
    library = folder / "libgravcomp_line.so"
    sources = [ROOT / "host" / name for name in SOURCES]
    subprocess.run(["cc", *STRICT, "-O2", f"-I{MACHINE}", "-shared", "-fPIC", "-o", library, *sources], check=True)
    return library


class CLineBus:
    """A bus whose registers the C driver reaches over a line: answer(frame) -> what comes back, maybe nothing."""

    def __init__(self, library: Path, answer: Callable[[bytes], bytes], unit: int = 1, attempts: int = 5):
        self._c, self._pending = ctypes.CDLL(str(library)), b""

        def send(_, data, n):
            self._pending = answer(bytes(data[:n]))

        def receive(_, data, n):
            part, self._pending = self._pending[:n], self._pending[n:]
            ctypes.memmove(data, part, len(part))
            return len(part)

        self._callbacks = SEND(send), RECEIVE(receive)  # kept: ctypes forgets what nothing refers to
        self.line, self._bus = CLine(*self._callbacks, None, unit, attempts), CBus()
        self.opened = LineResult(self._c.gravcomp_line_open(ctypes.byref(self.line), ctypes.byref(self._bus)))

    def read(self, offset: int) -> int:
        return self._bus.read(self._bus.context, offset)

    def write(self, offset: int, word: int) -> None:
        self._bus.write(self._bus.context, offset, word)

    def read_run(self, offset: int, n_words: int) -> list[int]:
        words = (ctypes.c_uint32 * n_words)()
        assert self._run("read", offset, words, n_words) == LineResult.OK
        return list(words)

    def write_run(self, offset: int, words: list[int]) -> LineResult:
        return self._run("write", offset, (ctypes.c_uint32 * len(words))(*words), len(words))

    def _run(self, verb: str, offset: int, words: ctypes.Array, n_words: int) -> LineResult:
        function = getattr(self._c, f"gravcomp_line_{verb}")
        return LineResult(function(ctypes.byref(self.line), ctypes.c_uint32(offset), words, ctypes.c_uint32(n_words)))
