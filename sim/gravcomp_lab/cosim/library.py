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

TOP, SERIAL_TOP = "gc_system", "gc_serial_system"
BUS_RATIO = 2  # clocks of the core in one of the bus
STEP_CLOCKS = 160  # of the core in a step of the physics; enough for three axes and 20 neurons, one by one
EDGE_CLOCKS = 4  # from edge to edge of an encoder, at least
MOST_AXES = 8
_STANDSTILL_S = 0.25  # without an edge
AROUND = tuple(Path(__file__).with_name(name) for name in ("cosim.v", "cosim.cpp"))
_VERILATOR = [
    *("--cc", "--exe", "--build", "-O3", "--x-assign", "fast", "--x-initial", "fast"),
    *("--default-language", "1364-2005", "--top-module", "cosim", "-LDFLAGS", "-shared"),
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


def build(machine: Path, rtl: Path, folder: Path, lanes: int = 1, baud: int | None = None) -> Path:
    """The library of the core of a machine folder that slow_machine made, compiled into a folder unless it is there.

    baud: it is behind a serial line, without motion and at the clock that it has on a board.

    Raises InputError when a tool is missing or refuses.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "build.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # of two that want it at once one compiles
        write_rom(machine, folder / "generated")
        sources = rtl_sources(rtl, folder / "generated")
        top = SERIAL_TOP if baud else TOP
        of_top = serial_generics(machine, baud) if baud else generics(machine, lanes)
        verilog = to_verilog(sources, top, of_top, folder / f"{top}.v")
        return compiled([verilog], top, folder, load_machine(machine).n_axes)


def serial_generics(machine: Path, baud: int) -> dict[str, int | str]:
    """Of the core of a machine folder behind a line; a pause of 3.5 characters ends a frame."""
    clock_hz = int(load_machine(machine).clock_hz)
    line = {"bus_clock_hz_g": clock_hz // BUS_RATIO, "baud_g": baud, "gap_us_g": 0}
    return {"lanes_g": 1, "clock_hz_g": clock_hz, **line}


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


def compiled(verilog: Sequence[Path], core: str, folder: Path, axes: int) -> Path:
    """The library of a module with the ports of gc_system for so many axes, compiled into a folder unless it is there.
    Raises InputError."""
    options = [*_VERILATOR, f"+define+CORE={core}", f"-GAXES={axes}"]
    options += ["+define+SERIAL"] if core == SERIAL_TOP else []
    content = b"".join(file.read_bytes() for file in (*verilog, *AROUND)) + repr(options).encode()
    key = hashlib.sha256(content).hexdigest()[:16]
    library = folder / f"cosim-{key}.so"
    if not library.exists():
        _compile([*options, *verilog], folder / f"verilated-{key}", library)
    return library


def _compile(arguments: Sequence[str | Path], folder: Path, library: Path) -> None:
    run_verilator([*arguments, *AROUND, "-CFLAGS", _COMPILER, "--Mdir", folder, "-o", "cosim.so"])
    (folder / "cosim.so").rename(library)
    shutil.rmtree(folder)
