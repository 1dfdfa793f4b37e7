"""How long a processor takes for one inference, and how much that varies: float32 in C, and NumPy."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.network.weights import Network

PERCENTILES = (50.0, 99.0, 99.9, 100.0)
C_FLAGS = {"C, -O3 -march=native -ffast-math": ["-ffast-math"], "C, -O3 -march=native": []}
C_CALLS, NUMPY_CALLS = 1_000_000, 50_000
_SOURCE = Path(__file__).with_name("inference.c")


@dataclass(frozen=True)
class Timing:
    """Percentiles of PERCENTILES of the time of one inference, ns, less the median time of a measurement of nothing."""

    name: str
    percentiles_ns: tuple[float, ...]


def compile_c(network: Network, q_m: np.ndarray, flags: list[str], out: Path) -> Path:
    """Compile the float32 network with the poses q_m (k, n) to a program in folder out; InputError without compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        raise InputError("cc: not found; install a C compiler, such as with apt-get install gcc")
    write_atomically(out / "weights.h", _header(network, q_m))
    program = out / "inference"
    command = [compiler, "-std=c11", "-O3", "-march=native", *flags, f"-I{out}", _SOURCE, "-o", program, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"cc: {(done.stderr.strip() or 'no message').splitlines()[0]}")
    return program


def run_c(program: Path, n_poses: int, n_axes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times of the calls and of as many measurements of nothing, ns, and forces (n_poses, n_axes), N."""
    output = subprocess.run([program.resolve()], capture_output=True, check=True).stdout
    times, forces_n = output[: 16 * C_CALLS], output[16 * C_CALLS :]
    call_ns, nothing_ns = np.frombuffer(times, dtype=np.int64).reshape(2, C_CALLS)
    return call_ns, nothing_ns, np.frombuffer(forces_n, dtype=np.float32).reshape(n_poses, n_axes)


def run_numpy(network: Network, q_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times of NUMPY_CALLS inferences in NumPy, one pose each, and of as many measurements of nothing, ns."""
    clock, call_ns, nothing_ns = time.perf_counter_ns, np.empty(NUMPY_CALLS), np.empty(NUMPY_CALLS)
    for k in range(NUMPY_CALLS):
        began = clock()
        network.forces(q_m[k % len(q_m)])
        call_ns[k] = clock() - began
        began = clock()
        nothing_ns[k] = clock() - began
    return call_ns, nothing_ns


def measure(programs: dict[str, Path], network: Network, q_m: np.ndarray, state: str) -> list[Timing]:
    """Timings of the C programs, by name, and of NumPy; state names what the machine does meanwhile."""
    timings = []
    for name, program in programs.items():
        call_ns, nothing_ns, _ = run_c(program, *q_m.shape)
        timings.append(timing(f"{name}, {state}", call_ns, nothing_ns))
    return [*timings, timing(f"NumPy, {state}", *run_numpy(network, q_m))]


def timing(name: str, call_ns: np.ndarray, nothing_ns: np.ndarray) -> Timing:
    """Percentiles of the times of calls, less the median of nothing."""
    found = np.percentile(call_ns, PERCENTILES) - np.median(nothing_ns)
    return Timing(name, tuple(float(value) for value in found))


def table(timings: Sequence[Timing]) -> str:
    """Markdown: one line per timing, ns, with its jitter: the largest less the median."""
    names = ["median", *(f"{value:g} %" for value in PERCENTILES[1:-1]), "largest", "jitter"]
    lines = ["| one inference, ns | " + " | ".join(names) + " |", "|---" * (1 + len(names)) + "|"]
    for row in timings:
        values = [*row.percentiles_ns, row.percentiles_ns[-1] - row.percentiles_ns[0]]
        lines.append(f"| {row.name} | " + " | ".join(f"{value:.0f}" for value in values) + " |")
    return "\n".join(lines)


@contextmanager
def load() -> Iterator[None]:
    """A busy process for every processor while the context lasts."""
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def _header(network: Network, q_m: np.ndarray) -> str:
    """weights.h: sizes, weights and poses as float constants."""
    tables = {
        "hidden_weights": network.hidden_weights.T,
        "hidden_bias": network.hidden_bias,
        "output_weights": network.output_weights,
        "output_bias": network.output_bias,
        "q_offset": network.q_offset,
        "q_scale": network.q_scale,
        "f_offset": network.f_offset,
        "f_scale": network.f_scale,
        "q_m": q_m,
    }
    sizes = {"AXES": network.n_axes, "NEURONS": network.n_hidden, "POSES": len(q_m), "CALLS": C_CALLS}
    lines = [f"#define {name} {value}" for name, value in sizes.items()]
    for name, values in tables.items():
        shape = "".join(f"[{size}]" for size in values.shape)
        numbers = ", ".join(f"{float(value)!r}f" for value in values.ravel())
        lines += [f"static const float {name}{shape} = {{{numbers}}};"]
    return "\n".join(lines) + "\n"
