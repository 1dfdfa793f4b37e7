"""host/linuxcnc: the component compiled against LinuxCNC's headers, run on its HAL library, before a model of a board.

Heartbeat and answers have longer times here than in the source: a loaded machine is no fault.
"""

import ctypes
import itertools
import math
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest

from c_host import MACHINE
from codes import ROOT
from gravcomp.facts import Cause
from support.model_board import ModelBoard, ModelCore, Noise
from test_py_board import core
from test_py_moving import mover

PLACES = (Path("/"), ROOT / "build" / "linuxcnc")
WHERE = next((place for place in PLACES if (place / "usr/include/linuxcnc/hal.h").exists()), None)
STRICT = ("-std=gnu11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
SOURCES = ("linuxcnc/gravcomp_hal.c", "gravcomp.c", "gravcomp_modbus.c", "gravcomp_motion.c")
BIT, FLOAT, U32 = 1, 2, 4  # hal_type_t
IN, OUT = 16, 32  # hal_pin_dir_t
C_TYPES = {BIT: ctypes.c_bool, FLOAT: ctypes.c_double, U32: ctypes.c_uint32}
INPUTS = {"enable": BIT, "heartbeat": BIT, "home": BIT, "move": BIT, "move-time": FLOAT,
          **{f"{k}.target": FLOAT for k in range(3)}}  # fmt: skip
OUTPUTS = {**dict.fromkeys(("connected", "released", "fault", "ready", "refused"), BIT), "causes": U32,
           **{f"{k}.position": FLOAT for k in range(3)}}  # fmt: skip
GLOBAL = {"tick-us": 100, "saturation-us": 10_000, "watchdog-us": 2_000_000, "result-us": 1000, "brake-us": 50,
          "command-us": 5000, "hold-us": 10_000}  # fmt: skip
OF_AXIS = {"margin-counts": 2000, "speed-max": 500_000, "current-limit-ua": 4_000_000, "current-slew-ua": 500_000,
           "command-bound-ua": 100_000}  # fmt: skip
SCALE = 1e6  # counts per m
PATIENCE_S = 20.0
ENABLE = 1  # bit of the register control
NUMBERS = itertools.count()

pytestmark = pytest.mark.skipif(WHERE is None, reason="no headers of LinuxCNC; `scripts/linuxcnc.sh` unpacks Debian's")


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    out = tmp_path_factory.mktemp("linuxcnc") / "gravcomp_hal"
    library = WHERE / "usr/lib"
    options = ["-DULAPI", "-DHEARTBEAT_MS=1500", "-DANSWER_MS=400", "-isystem", WHERE / "usr/include/linuxcnc"]
    paths = [f"-I{ROOT / 'host'}", f"-I{MACHINE}", f"-L{library}", f"-Wl,-rpath,{library}"]
    sources = [ROOT / "host" / name for name in SOURCES]
    subprocess.run(["cc", *STRICT, *options, *paths, *sources, "-llinuxcnchal", "-lm", "-o", out], check=True)
    return out


class Machine:
    """LinuxCNC's side of the component: signals to its inputs, from its outputs, and a heartbeat."""

    def __init__(self, program: Path, port: str):
        self.name = f"gravcomp{os.getpid()}x{next(NUMBERS)}"
        self.process = subprocess.Popen([program, "-n", self.name, port], stderr=subprocess.PIPE, text=True)
        self._hal = ctypes.CDLL(str(WHERE / "usr/lib/liblinuxcnchal.so.0"))
        self._hal.hal_malloc.restype = ctypes.c_void_p
        self._id = self._hal.hal_init(f"{self.name}-test".encode())
        assert self._id > 0
        self._pins, self.beats = {}, True
        self.until(self._is_there, "the component has its parameters")
        time.sleep(0.2)  # for the rest of them
        for name, kind in {**INPUTS, **OUTPUTS}.items():
            self._pins[name] = self._linked(name, kind, OUT if name in INPUTS else IN)
        for name, value in GLOBAL.items():
            self.parameter(name, value)
        for axis in range(3):
            for name, value in OF_AXIS.items():
                self.parameter(f"{axis}.{name}", value)
            assert self._hal.hal_param_float_set(f"{self.name}.{axis}.scale".encode(), ctypes.c_double(SCALE)) == 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def _is_there(self) -> bool:
        assert self.process.poll() is None, self.process.stderr.read()
        return self._hal.hal_param_u32_set(f"{self.name}.2.index-period".encode(), ctypes.c_ulong(0)) == 0

    def _linked(self, name: str, kind: int, direction: int) -> ctypes.c_void_p:
        slot, own, link = self._hal.hal_malloc(8), f"{self.name}-test.{name}".encode(), f"{self.name}-s-{name}".encode()
        assert self._hal.hal_pin_new(own, kind, direction, ctypes.c_void_p(slot), self._id) == 0
        assert self._hal.hal_signal_new(link, kind) == 0
        for pin in (own, f"{self.name}.{name}".encode()):
            assert self._hal.hal_link(pin, link) == 0
        return slot

    def parameter(self, name: str, value: int) -> None:
        assert self._hal.hal_param_u32_set(f"{self.name}.{name}".encode(), ctypes.c_ulong(value)) == 0

    def _value(self, name: str):
        kind = C_TYPES[{**INPUTS, **OUTPUTS}[name]]
        return kind.from_address(ctypes.c_void_p.from_address(self._pins[name]).value)

    def __getitem__(self, name: str):
        return self._value(name).value

    def __setitem__(self, name: str, value) -> None:
        self._value(name).value = value

    def _beat(self) -> None:
        while not self._stop.wait(0.02):
            if self.beats:
                self["heartbeat"] = not self["heartbeat"]

    def until(self, holds, what: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end, f"not in time: {what}"
            time.sleep(0.01)

    def turn_on(self) -> None:
        self["enable"] = True
        self.until(lambda: self["released"], "brakes released")

    def close(self) -> int:
        self._stop.set()
        self._thread.join()
        self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(PATIENCE_S)
        self.process.stderr.close()
        self._hal.hal_exit(self._id)
        return status


@pytest.fixture
def board():
    with ModelBoard(core()) as model:
        yield model


@pytest.fixture
def machine(program, board):
    machine = Machine(program, board.port)
    yield machine
    if machine.process.poll() is None:
        machine.close()


def is_enabled(board) -> bool:
    return bool(board.core.get("control") & ENABLE)


def test_component_releases_shows_kicks_and_engages_at_its_end(machine, board):
    machine.until(lambda: machine["connected"], "connected")
    assert not machine["released"]
    shown = [1000 / SCALE, -500 / SCALE]
    machine.until(lambda: [machine["0.position"], machine["1.position"]] == pytest.approx(shown), "positions in m")
    machine.turn_on()
    kicks = board.core.kicks
    machine.until(lambda: board.core.kicks > kicks + 20, "kicks go on")
    assert is_enabled(board)
    assert machine.close() == 0
    assert not is_enabled(board)


def heartbeat_stops(machine, board):
    machine.beats = False


def core_faults(machine, board):
    board.core.fault(Cause.ESTOP)


def line_is_cut(machine, board):
    board.noise.silent = True


def is_disabled(machine, board):
    machine["enable"] = False


@pytest.mark.parametrize("what", [heartbeat_stops, core_faults, line_is_cut])
def test_any_error_ends_the_kicks_and_engages_until_enable_was_low(what, machine, board):
    machine.turn_on()
    what(machine, board)
    machine.until(lambda: machine["fault"], "a fault")
    if what is line_is_cut:
        assert not machine["connected"]
        board.noise.silent = False
        machine.until(lambda: machine["connected"], "connected again")
    machine.beats = True
    machine.until(lambda: not is_enabled(board), "brakes engaged")
    kicks = board.core.kicks
    time.sleep(0.5)
    assert (board.core.kicks, is_enabled(board), machine["fault"]) == (kicks, False, True)
    for name in ("fault", "cause", "first_cause"):
        board.core.put(name, 0)
    machine["enable"] = False
    machine.until(lambda: not machine["fault"], "fault is over")
    machine.turn_on()


def test_enable_that_falls_engages_without_a_fault(machine, board):
    machine.turn_on()
    machine["enable"] = False
    machine.until(lambda: not is_enabled(board), "brakes engaged")
    machine.until(lambda: not machine["released"], "brakes seen engaged")
    assert not machine["fault"]


def test_limits_of_zero_release_nothing(machine, board):
    machine.parameter("1.current-slew-ua", 0)
    machine["enable"] = True
    machine.until(lambda: machine["fault"], "a fault")
    assert not is_enabled(board)


def test_targets_are_moved_to_and_nonsense_is_refused(program):
    with ModelBoard(mover()) as board:
        machine = Machine(program, board.port)
        machine.turn_on()
        machine.until(lambda: machine["ready"], "ready")
        for axis, target in enumerate((0.01, -0.02, math.nan)):
            machine[f"{axis}.target"] = target
        machine["move"] = True
        machine.until(lambda: machine["refused"], "refused")
        assert board.core.targets == []
        machine["move"] = False
        machine["2.target"] = 0.0
        time.sleep(0.3)
        machine["move"] = True
        machine.until(lambda: board.core.targets, "moved")
        machine.until(lambda: not machine["refused"], "taken")
        assert [(count + 2**31) % 2**32 - 2**31 for count in board.core.targets[0]] == [10_000, -20_000, 0]
        assert machine.close() == 0


@pytest.mark.parametrize(
    ("model", "told"),
    [
        (core(weights_hash=[1] * 8), "the core is of another machine; compile with"),
        (ModelCore(id=1), "no gravcomp core, or another version"),
    ],
)
def test_another_core_is_refused_in_a_line(model, told, program):
    with ModelBoard(model) as board:
        done = subprocess.run([program, board.port], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert told in done.stderr


def test_wrong_ports_and_arguments_are_refused_in_a_line(program, tmp_path):
    with ModelBoard(core(), Noise(silent=True)) as silent:
        cases = {
            "no port; give": [],
            "wrong argument; give": ["-u", "300", "x"],
            "is no serial port": [tmp_path / "none"],
            "nothing answers; check": [silent.port],
        }
        for told, arguments in cases.items():
            done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60)
            assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
            assert told in done.stderr
