"""gc_system with motion as a shared library: GHDL's Verilog, compiled by Verilator, stepped from Python by ctypes.

The core's clock is slow: 160 kHz, say, instead of tens of MHz, with the pipeline as it is, so that a tick of the servo,
which is a step of the physics, has little more clocks than the core needs for it. Everything that counts in seconds,
speeds, friction and time-outs, counts by that clock, since the machine folder says so: nothing else is scaled.
"""

import ctypes
import fcntl
import hashlib
import re
import shutil
from collections.abc import Sequence
from pathlib import Path

from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.robot.machine import ROBOT_TOML, load_machine
from gravcomp.simulation.simulator import compiler_effort
from gravcomp_lab.synthesis.verilator import run_verilator
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog

TOP = "gc_system"
STEP_CLOCKS = 160  # of the core in a step of the physics; enough for three axes and 20 neurons, one by one
EDGE_CLOCKS = 4  # from edge to edge of an encoder, at least
MOST_AXES = 8
_STANDSTILL_S = 0.25  # without an edge
WRAPPER = Path(__file__).with_name("cosim.cpp")
_VERILATOR = [
    *("--cc", "--exe", "--build", "-O3", "--x-assign", "fast", "--x-initial", "fast"),
    *("--default-language", "1364-2005", "--prefix", f"V{TOP}", "-LDFLAGS", "-shared"),
    *compiler_effort(1),
    *("-Wno-lint", "-Wno-COMBDLY", "-Wno-INITIALDLY", "-Wno-UNOPTFLAT"),
]
_COMPILER = "-fPIC -std=c++20"


class Port(ctypes.Structure):
    """What core and world share; cosim.cpp says what each is."""

    _fields_ = (
        ("clock", ctypes.c_uint64),
        *((name, ctypes.c_uint32) for name in ("axes", "step_clocks", "step_clock")),
        *((name, ctypes.c_int32 * MOST_AXES) for name in ("position", "target", "index", "sense_ua", "command_ua")),
        *((name, ctypes.c_uint32) for name in ("released", "enabled", "estop", "data", "error")),
        ("jump", ctypes.c_int32 * MOST_AXES),
    )


def slow_machine(folder: Path, out: Path, step_clocks: int = STEP_CLOCKS) -> Path:
    """A copy of a machine folder whose core has so many clocks in a step of the physics, in out; returns out."""
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(folder, out)
    clock = f"clock_hz = {round(step_clocks / TIME_STEP_S)}"
    text, found = re.subn(r"(?m)^clock_hz\s*=.*$", clock, (out / ROBOT_TOML).read_text())
    if found != 1:
        raise InputError(f"{folder / ROBOT_TOML}: clock_hz stands not once at the start of a line; write it so")
    write_atomically(out / ROBOT_TOML, text)
    return out


def build(machine: Path, rtl: Path, folder: Path, lanes: int = 1) -> Path:
    """The library of the core of a machine folder that slow_machine made, compiled into a folder unless it is there.

    Raises InputError when a tool is missing or refuses.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "build.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # of two that want it at once one compiles
        write_rom(machine, folder / "generated")
        sources = rtl_sources(rtl, folder / "generated")
        return compiled([to_verilog(sources, TOP, generics(machine, lanes), folder / f"{TOP}.v")], TOP, folder)


def generics(machine: Path, lanes: int = 1) -> dict[str, int | str]:
    """Of the core of such a machine folder."""
    clock_hz = int(load_machine(machine).clock_hz)
    return {
        "lanes_g": lanes,
        "motion_g": "true",
        "clock_hz_g": clock_hz,
        "filter_samples_g": 0,
        "speed_timeout_g": round(_STANDSTILL_S * clock_hz),
        "reversal_clocks_g": EDGE_CLOCKS,
        "dither_clocks_g": EDGE_CLOCKS,
    }


def compiled(verilog: Sequence[Path], top: str, folder: Path) -> Path:
    """The library of a module with the ports of gc_system, compiled into a folder unless it is there. Raises
    InputError."""
    content = b"".join(file.read_bytes() for file in (*verilog, WRAPPER)) + repr((_VERILATOR, top)).encode()
    key = hashlib.sha256(content).hexdigest()[:16]
    library = folder / f"cosim-{key}.so"
    if not library.exists():
        _compile(verilog, top, folder / f"verilated-{key}", library)
    return library


def _compile(verilog: Sequence[Path], top: str, folder: Path, library: Path) -> None:
    options = ["--top-module", top, "-CFLAGS", _COMPILER, "--Mdir", folder, "-o", "cosim.so"]
    run_verilator([*_VERILATOR, *options, *verilog, WRAPPER])
    (folder / "cosim.so").rename(library)
    shutil.rmtree(folder)
