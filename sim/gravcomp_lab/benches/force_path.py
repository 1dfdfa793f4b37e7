"""gc_force_path through its encoder pins: a robot's poses and motions, and what the core answers."""

import os
from collections.abc import Callable
from pathlib import Path

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from gravcomp.core.cost import CoreCost
from gravcomp.core.formats import COUNT_BITS, FORCE_BITS, FixedNetwork
from gravcomp.robot.machine import load_machine
from gravcomp.simulation.measured import hand_over
from gravcomp_lab.benches.bench import run_bench
from gravcomp_lab.benches.codes import fixed_network, pack, unpack, weights_under_test
from gravcomp_lab.shipped import ROOT
from gravcomp_lab.simulated.poses import motion, pose_sets
from gravcomp_lab.simulated.run import SimulatedRun

BENCH_SOURCES = tuple(ROOT / "tb" / "hdl" / f"{name}.vhd" for name in ("gc_encoder_model", "gc_force_path_bench"))
CLOCKS_PER_EDGE = 4
CLOCKS_PER_PERIOD = 600  # of 1 ms: the slowest clock that keeps up with the edges is the cheapest to simulate
CLOCK_NS = 2 * round(1e6 / CLOCKS_PER_PERIOD / 2)
TRAVEL_CLOCKS = 1000  # the longest way between two poses here
INFERENCE_CLOCKS = 200
LATENCY_CLOCKS = 190  # of gc_force_path, most in the form serial, with some to spare
DECODER_CLOCKS = 12  # synchroniser, filter and count, with some to spare


def core_cost(fixed: FixedNetwork, lanes: int) -> CoreCost:
    """Of a network in the form that it has."""
    return CoreCost(fixed.n_hidden, fixed.n_inputs, fixed.n_axes, lanes, fixed.is_lean, fixed.is_serial)


class Bench:
    """The axes and the core of gc_force_path_bench."""

    def __init__(self, dut):
        self.dut = dut
        self.n_clocks = 0
        self.clocks_behind_core = core_cost(fixed_network(), int(os.environ["LANES_G"])).clocks_behind()

    async def start(self) -> None:
        Clock(self.dut.clk, CLOCK_NS, "ns").start(start_high=False)
        for port in ("target", "index_count", "load", "home_enable", "in_valid"):
            getattr(self.dut, port).value = 0
        self.dut.clocks_per_edge.value = CLOCKS_PER_EDGE
        self.dut.rst.value = 1
        await self.clocks(4)
        self.dut.rst.value = 0
        await self.clocks(DECODER_CLOCKS)

    async def clocks(self, n: int) -> None:
        self.n_clocks += n
        for _ in range(n):
            await FallingEdge(self.dut.clk)

    async def until(self, is_true: Callable[[], bool], most_clocks: int) -> None:
        for _ in range(most_clocks):
            if is_true():
                return
            await self.clocks(1)
        raise AssertionError(f"waited {most_clocks} clocks in vain")

    async def home_near(self, counts: np.ndarray) -> None:
        """Home the axes at indices beside the counts: a jump of whole encoder cycles, the last two on the pins."""
        index = counts - (counts - 2) % 4  # the decoder takes the index in phase 2
        self.dut.index_count.value = self.dut.target.value = pack(index - 8, COUNT_BITS)
        self.dut.load.value = 1
        self.dut.home_enable.value = 0
        await self.clocks(1)
        self.dut.load.value = 0
        self.dut.home_enable.value = 1
        self.dut.index_count.value = pack(index, COUNT_BITS)
        await self.walk_to(index)
        assert self.dut.sts_referenced.value == 2 ** len(counts) - 1

    async def walk_to(self, counts: np.ndarray) -> None:
        self.dut.target.value = pack(counts, COUNT_BITS)
        await self.clocks(1)
        await self.until(lambda: self.dut.busy.value == 0, TRAVEL_CLOCKS)
        await self.clocks(DECODER_CLOCKS)

    async def infer(self) -> list[int]:
        """Run one inference; returns the packed count, speed period, force, current and flags."""
        self.dut.in_valid.value = 1
        assert self.dut.in_ready.value == 1
        count = int(self.dut.sts_count.value)
        await self.clocks(1)
        self.dut.in_valid.value = 0
        periods = []
        while self.dut.out_valid.value != 1:
            assert len(periods) < INFERENCE_CLOCKS, f"no result in {INFERENCE_CLOCKS} clocks"
            periods.append(int(self.dut.sts_speed_period.value))
            await self.clocks(1)
        return [count, periods[-self.clocks_behind_core], *self.outputs()]

    def outputs(self) -> list[int]:
        """Packed force, current and flags."""
        ports = (self.dut.out_force, self.dut.out_current, self.dut.out_clamped, self.dut.out_saturated)
        return [int(port.value) for port in ports]

    async def infer_all_along(self, n_clocks: int) -> list[list[int]]:
        """Infer whenever the core is ready, for so many clocks, then wait for the last result; as infer, a row each.

        For weights without compensation: which speed goes with which result is not recorded.
        """
        counts, outputs = [], []
        for k in range(n_clocks + LATENCY_CLOCKS):
            self.dut.in_valid.value = int(k < n_clocks)
            if k < n_clocks and self.dut.in_ready.value == 1:
                counts.append(int(self.dut.sts_count.value))
            await self.clocks(1)
            if self.dut.out_valid.value == 1:
                outputs.append(self.outputs())
        return [[count, 0, *row] for count, row in zip(counts, outputs, strict=True)]


@cocotb.test()
async def poses(dut):
    """An inference at rest at every pose of the sets."""
    sets = pose_sets(load_machine(weights_under_test()))
    counts = np.concatenate(list(sets.values()))
    bench, answers = Bench(dut), []
    await bench.start()
    for pose_counts in counts:
        await bench.home_near(pose_counts)
        await bench.walk_to(pose_counts)
        answers.append(await bench.infer())
    hand_over(sets=[name for name, own in sets.items() for _ in own], counts=counts, answers=answers)


@cocotb.test()
async def continuous_motion(dut):
    """An inference a period along POSES poses of a motion, from START_S on."""
    n_poses = int(os.environ["POSES"])
    counts = motion(load_machine(weights_under_test()), n_poses, float(os.environ["START_S"]))
    bench, answers = Bench(dut), []
    await bench.start()
    await bench.home_near(counts[0])
    for pose_counts in counts:
        period_ends = bench.n_clocks + CLOCKS_PER_PERIOD
        await bench.walk_to(pose_counts)
        answers.append(await bench.infer())
        assert bench.n_clocks <= period_ends, "the motion is too fast for its period"
        await bench.clocks(period_ends - bench.n_clocks)
    assert dut.sts_illegal.value == 0
    assert dut.sts_glitch.value == 0
    hand_over(sets=["motion"] * n_poses, counts=counts, answers=answers)


def pose_run(rtl: Path, build: Path, weights: Path) -> SimulatedRun:
    """The poses of the workspace through gc_force_path with one lane, whose ROM in rtl was made from weights."""
    return _run("poses", 1, rtl, build, weights)


def motion_run(rtl: Path, build: Path, weights: Path, vcd: Path, n_poses: int = 16) -> SimulatedRun:
    """A short motion with four lanes, and its waveform."""
    return _run("continuous_motion", 4, rtl, build, weights, vcd=vcd, POSES=str(n_poses), START_S="0.18")


def _run(
    name: str, lanes: int, rtl: Path, build: Path, weights: Path, vcd: Path | None = None, **more: str
) -> SimulatedRun:
    measured = run_bench(
        "gc_force_path_bench",
        __name__,
        lanes,
        rtl,
        build / name,
        {"WEIGHTS": str(weights.absolute()), **more},
        BENCH_SOURCES,
        tests=f"{name}$",
        vcd=vcd and vcd.absolute(),
    )
    counts, (_, period, force, *_) = np.array(measured["counts"]), zip(*measured["answers"], strict=True)
    n_axes = counts.shape[1]
    return SimulatedRun(
        np.array(measured["sets"]), counts, unpack(period, 32, n_axes), unpack(force, FORCE_BITS, n_axes)
    )
