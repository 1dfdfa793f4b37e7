"""gc_force_path end to end: robot poses through the encoder pins; forces and currents equal the bit-true model.

Leaves what the core answered in build/sim/, from which `make sim` prints its table and draws its pictures.
"""

import csv
import os
import time
from collections.abc import Callable

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from codes import fixed_compensation, fixed_network, pack, unpack
from compensated import compensated_weights
from gravcomp.core.formats import COUNT_BITS, CURRENT_BITS, FORCE_BITS
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.facts import COMPENSATOR_CLOCKS, CURRENT_SCALER_CLOCKS
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp_lab.simulated.poses import motion, pose_sets
from machines import MACHINE
from runner import BENCHES, BUILD, simulate

RESULTS = BUILD / "sim"
CLOCKS_PER_EDGE = 4
CLOCKS_PER_PERIOD = 600  # of 1 ms: the slowest clock that keeps up with the edges is the cheapest to simulate
CLOCK_NS = 2 * round(1e6 / CLOCKS_PER_PERIOD / 2)
TRAVEL_CLOCKS = 1000  # the longest way between two poses here
INFERENCE_CLOCKS = 100
# From the forces of gc_core, beside which the compensator takes the speed, to the result.
CLOCKS_BEHIND_CORE = COMPENSATOR_CLOCKS + CURRENT_SCALER_CLOCKS + 1
LATENCY_CLOCKS = 45  # of gc_force_path with 2 lanes or more, with some to spare
DECODER_CLOCKS = 12  # synchroniser, filter and count, with some to spare


class Bench:
    """The axes and the core of gc_force_path_bench."""

    def __init__(self, dut):
        self.dut = dut
        self.n_clocks = 0

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
        return [count, periods[-CLOCKS_BEHIND_CORE], *self.outputs()]

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


def check(counts: np.ndarray, answers: list[list[int]]) -> np.ndarray:
    """Assert that every answer equals the bit-true model; returns the forces, mN."""
    fixed, n = fixed_network(), counts.shape[1]
    count, period, force, current, clamped, saturated = (list(column) for column in zip(*answers, strict=True))
    np.testing.assert_array_equal(unpack(count, COUNT_BITS, n), counts)
    expected = bittrue.core(counts, fixed)
    expected_mn, is_unfit = compensator(expected.force_mn, counts, unpack(period, 32, n), fixed_compensation())
    force_mn = unpack(force, FORCE_BITS, n)
    np.testing.assert_array_equal(force_mn, expected_mn)
    np.testing.assert_array_equal(unpack(current, CURRENT_BITS, n), bittrue.current_scaler(expected_mn, fixed))
    np.testing.assert_array_equal(unpack(clamped, 1, n) != 0, expected.clamped)
    np.testing.assert_array_equal(unpack(saturated, 1, n) != 0, expected.saturated | is_unfit)
    return force_mn


def check_and_save(name: str, sets: list[str], counts: np.ndarray, answers: list[list[int]]) -> None:
    """Assert that every answer equals the bit-true model, then write build/sim/<name>.csv."""
    force_mn, n = check(counts, answers), counts.shape[1]
    RESULTS.mkdir(parents=True, exist_ok=True)
    with (RESULTS / f"{name}.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["set", *(f"count{i + 1}" for i in range(n)), *(f"f{i + 1}_mn" for i in range(n))])
        writer.writerows([s, *c, *f] for s, c, f in zip(sets, counts.tolist(), force_mn.tolist(), strict=True))


@cocotb.test()
async def poses(dut):
    sets = pose_sets(MACHINE)
    names = [name for name, counts in sets.items() for _ in counts]
    counts = np.concatenate(list(sets.values()))
    bench, answers, began = Bench(dut), [], time.perf_counter()
    await bench.start()
    for pose_counts in counts:
        await bench.home_near(pose_counts)
        await bench.walk_to(pose_counts)
        answers.append(await bench.infer())
    seconds = time.perf_counter() - began
    print(f"MEASURED {len(counts)} poses, {bench.n_clocks} clocks, {bench.n_clocks / seconds:.0f} clocks/s")
    check_and_save("poses", names, counts, answers)


@cocotb.test()
async def continuous_motion(dut):
    name, n_poses = os.environ["RUN"], int(os.environ["POSES"])
    counts = motion(MACHINE, n_poses, float(os.environ["START_S"]))
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
    check_and_save(name, [name] * n_poses, counts, answers)


@cocotb.test()
async def end_of_the_trained_range(dut):
    """Results follow each other while axes cross the end of their range: each has the flags of its own counts."""
    fixed, bench = fixed_network(), Bench(dut)
    n = fixed.n_axes
    await bench.start()
    await bench.home_near(fixed.count_high - 4 * np.arange(1, n + 1))
    dut.target.value = pack(fixed.count_high + 2, COUNT_BITS)
    answers = await bench.infer_all_along(90)
    counts = unpack([row[0] for row in answers], COUNT_BITS, n)
    check(counts, answers)
    assert len(np.unique((counts > fixed.count_high).sum(axis=1))) > 2, "the axes did not cross one after the other"
    dut.in_valid.value = 1
    await bench.clocks(30)
    dut.rst.value = 1
    await bench.clocks(1)
    dut.rst.value = 0
    assert dut.in_ready.value == 0, "ready before the decoders have counts"
    assert bench.outputs() == [0, 0, 0, 0]
    answers = await bench.infer_all_along(30)
    check(unpack([row[0] for row in answers], COUNT_BITS, n), answers)


@cocotb.test()
async def forces_that_do_not_fit(dut):
    """Friction that takes a force past 24 bits saturates the command and flags it, though the network's force fits."""
    counts = motion(MACHINE, 3, 0.18)[::-1]  # upwards: friction adds to the force
    bench, answers = Bench(dut), []
    await bench.start()
    await bench.home_near(counts[0])
    for pose_counts in counts:
        await bench.walk_to(pose_counts)
        answers.append(await bench.infer())
    check(counts, answers)
    flags = [int(answer[-1]) for answer in answers]
    assert any(flags), "no force went past 24 bits"
    assert not bittrue.core(counts, fixed_network()).saturated.any()


def simulate_top(cocotb_test: str, **options) -> None:
    simulate(
        "gc_force_path_bench",
        "test_rtl_force_path",
        tests=f"{cocotb_test}$",
        label=options.pop("label", cocotb_test),
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_force_path_bench")),
        **options,
    )


@pytest.mark.slow
def test_top_equals_model_at_poses_of_the_workspace():
    simulate_top("poses", generics={"lanes_g": 1})


@pytest.mark.slow
def test_top_follows_a_continuous_motion_without_losing_a_count():
    environment = {"RUN": "motion", "POSES": "200", "START_S": "0"}
    simulate_top("continuous_motion", generics={"lanes_g": 1}, environment=environment)


def test_top_flags_the_counts_they_belong_to_and_forgets_all_at_a_reset():
    simulate_top("end_of_the_trained_range", generics={"lanes_g": 20})  # a result per clock: no flag may be late


def test_top_with_a_compensator_follows_a_short_motion(tmp_path):
    folder = compensated_weights(tmp_path)
    environment = {"RUN": "compensated", "POSES": "4", "START_S": "0.18", "WEIGHTS": str(folder)}
    simulate_top(
        "continuous_motion",
        label="compensated",
        generics={"lanes_g": 4},
        environment=environment,
        generated=folder / "generated",
    )


def test_top_flags_a_force_that_friction_takes_past_its_format(tmp_path):
    clock = "axis,name,value\nall,v_dead,2e-4\nall,v_full,4e-4\n"
    folder = compensated_weights(tmp_path, clock + "1,mu,0.999\n2,mu,0.999\n3,mu,0.999\n")
    scaling = (folder / "scaling.csv").read_text().replace("58.5,71.5", "5000,2000")  # 3 to 7 kN; 8.4 kN fit
    (folder / "scaling.csv").write_text(scaling)
    write_rom(folder, folder / "generated")
    simulate_top(
        "forces_that_do_not_fit",
        generics={"lanes_g": 4},
        environment={"WEIGHTS": str(folder)},
        generated=folder / "generated",
    )


def test_top_leaves_a_waveform_of_a_short_motion():
    vcd = RESULTS / "run.vcd"
    vcd.parent.mkdir(parents=True, exist_ok=True)
    environment = {"RUN": "run", "POSES": "16", "START_S": "0.18"}
    simulate_top("continuous_motion", label="vcd", generics={"lanes_g": 4}, environment=environment, vcd=vcd)
    assert vcd.stat().st_size > 0
