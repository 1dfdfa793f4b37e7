"""gc_core under counts back to back: what it answers, and when."""

import os
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cocotb
import numpy as np

from gravcomp.core.cost import CoreCost
from gravcomp.core.formats import COUNT_BITS, FORCE_BITS
from gravcomp.errors import InputError
from gravcomp.simulation.measured import hand_over
from gravcomp_lab.benches.bench import run_bench
from gravcomp_lab.benches.codes import corners_and_random, fixed_network, pack, unpack
from gravcomp_lab.benches.stream import start, stream

LANES = (1, 2, 4, 5, 10, 20)  # of 20 neurons
OUTPUTS = ("out_force", "out_clamped", "out_saturated")


@dataclass(frozen=True)
class CoreRun:
    """k inferences of n axes. count, force_mn, clamped, saturated (k, n); accepted, valid (k,): clocks of counts taken
    and of their forces; clocks_per_s: how fast the simulator was.
    """

    count: np.ndarray
    force_mn: np.ndarray
    clamped: np.ndarray
    saturated: np.ndarray
    accepted: np.ndarray
    valid: np.ndarray
    clocks_per_s: float

    @property
    def interval(self) -> int:
        """Clocks from counts to the next counts. AssertionError unless it is always the same."""
        return _only(np.diff(self.accepted))

    @property
    def latency(self) -> int:
        """Clocks from counts to their forces. AssertionError unless it is always the same."""
        return _only(self.valid - self.accepted)


def draw_counts(n_poses: int, rng: np.random.Generator) -> np.ndarray:
    """Counts over the trained range, one in eight a corner of 32 bits or of the range; at most POSES, where it is set:
    gates are simulated slowly.
    """
    fixed = fixed_network()
    shape = (min(n_poses, int(os.environ.get("POSES", n_poses))), fixed.n_axes)
    counts = rng.integers(fixed.count_low, fixed.count_high, shape, endpoint=True)
    edges = rng.choice(
        np.concatenate([fixed.count_low + k for k in (-1, 0)] + [fixed.count_high + k for k in (0, 1)]), shape
    ).clip(-(2 ** (COUNT_BITS - 1)), 2 ** (COUNT_BITS - 1) - 1)
    odd = np.where(rng.random(shape) < 0.5, edges, corners_and_random(COUNT_BITS, shape, rng))
    return np.where(rng.random(shape) < 0.125, odd, counts)


def inputs_of(counts: np.ndarray) -> list[dict[str, int]]:
    return [{"in_count": pack(row, COUNT_BITS)} for row in counts]


def flush_clocks() -> int:
    """Clocks in which the last result comes, with any number of lanes: one per neuron, and all pipelines; those of
    CoreCost in the serial form."""
    fixed = fixed_network()
    cost = CoreCost(fixed.n_hidden, fixed.n_inputs, fixed.n_axes, 1, fixed.is_lean, fixed.is_serial)
    return 64 + (cost.latency if fixed.is_serial else fixed.n_hidden)


@cocotb.test()
async def back_to_back(dut):
    """Counts whenever the core takes them, 40 per lane up to 200."""
    counts = draw_counts(40 * min(int(os.environ["LANES_G"]), 5), np.random.default_rng(10))
    await start(dut)
    began = time.perf_counter()
    got = await stream(dut, inputs_of(counts), OUTPUTS, has_ready=True, flush_clocks=flush_clocks())
    clocks_per_s = (got.valid[-1] + 1) / (time.perf_counter() - began)
    hand_over(count=counts, clocks_per_s=clocks_per_s, **vars(got))


def core_run(lanes: int, rtl: Path, build: Path, weights: Path, generated: Path | None = None) -> CoreRun:
    """The run of gc_core with so many lanes, simulated under GHDL with the ROM in rtl, or in generated, made from
    weights."""
    environment = {"WEIGHTS": str(weights.absolute())}
    folder = build / f"core-{lanes}"
    return run_of(run_bench("gc_core", __name__, lanes, rtl, folder, environment, generated=generated))


def distinct_lanes(lanes: Iterable[int]) -> list[int]:
    """The numbers of lanes in order, each once. Raises InputError for one below 1."""
    for number in lanes:
        if number < 1:
            raise InputError(f"--lanes {number}: give 1 or more")
    return sorted(set(lanes))


def _only(clocks: np.ndarray) -> int:
    found = set(clocks.tolist())
    assert len(found) == 1, f"{sorted(found)} clocks"
    return found.pop()


def run_of(measured: dict) -> CoreRun:
    """The run that a simulation of back_to_back handed over."""
    counts = np.array(measured["count"])
    force, clamped, saturated = (measured["outputs"][name] for name in OUTPUTS)
    n_axes = counts.shape[1]
    return CoreRun(
        count=counts,
        force_mn=unpack(force, FORCE_BITS, n_axes),
        clamped=unpack(clamped, 1, n_axes) != 0,
        saturated=unpack(saturated, 1, n_axes) != 0,
        accepted=np.array(measured["accepted"]),
        valid=np.array(measured["valid"]),
        clocks_per_s=measured["clocks_per_s"],
    )
