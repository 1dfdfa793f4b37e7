"""gc_force_path end to end: robot poses through the encoder pins; forces and currents equal the bit-true model."""

import os
from dataclasses import replace
from unittest.mock import patch

import cocotb
import numpy as np
import pytest

from codes import fixed_compensation, fixed_network, pack, unpack, weights_under_test
from compensated import compensated_weights
from gravcomp.core.formats import COUNT_BITS, CURRENT_BITS, FORCE_BITS
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp_lab.benches.force_path import (
    BENCH_SOURCES,
    Bench,
    continuous_motion,  # noqa: F401, cocotb finds it here
    core_cost,
    motion_run,
    poses,  # noqa: F401
)
from gravcomp_lab.simulated.poses import motion
from gravcomp_lab.simulated.run import error_table
from machines import MACHINE, shipped_in
from runner import RTL, simulate
from support.ghdl import walks_the_hierarchy


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
    assert flags[-1], "the last force did not go past 24 bits"
    dut.rst.value = 1
    await bench.clocks(1)
    assert bench.outputs() == [0, 0, 0, 0]
    assert not bittrue.core(counts, fixed_network()).saturated.any()


@cocotb.test()
async def flags_one_after_the_other(dut):
    """Counts are taken as soon as they can be, while axes leave their range slowly: each result has its own flags, at
    the latency of the header."""
    fixed, bench = fixed_network(), Bench(dut)
    n = fixed.n_axes
    await bench.start()
    await bench.home_near(fixed.count_high - 4 * np.arange(1, n + 1))
    dut.clocks_per_edge.value = 80
    dut.target.value = pack(fixed.count_high + 2, COUNT_BITS)
    answers = await bench.infer_all_along(1200)
    counts = unpack([row[0] for row in answers], COUNT_BITS, n)
    check(counts, answers)
    assert len(np.unique((counts > fixed.count_high).sum(axis=1))) > 2, "the axes did not cross one after the other"
    began, compensated = bench.n_clocks, os.environ["COMPENSATED_G"] == "true"
    await bench.infer()
    core = core_cost(fixed, int(os.environ["LANES_G"]))
    assert bench.n_clocks - began == core.latency + core.clocks_behind(compensated)
    dut.rst.value = 1
    await bench.clocks(1)
    assert bench.outputs() == [0, 0, 0, 0]


def simulate_top(cocotb_test: str, **options) -> dict:
    """Run a cocotb test of this module; what it handed over, its answers checked."""
    measured = simulate(
        "gc_force_path_bench",
        "test_rtl_force_path",
        tests=rf"\.{cocotb_test}$",
        label=options.pop("label", cocotb_test),
        extra_sources=BENCH_SOURCES,
        **options,
    )
    if measured:
        with patch.dict(os.environ, options.get("environment", {})):  # the machine under test, for the model too
            check(np.array(measured["counts"]), measured["answers"])
    return measured


@pytest.mark.slow
def test_top_equals_model_at_poses_of_the_workspace():
    assert len(simulate_top("poses", generics={"lanes_g": 1})["answers"]) == 600


@pytest.mark.slow
def test_top_follows_a_continuous_motion_without_losing_a_count():
    environment = {"POSES": "200", "START_S": "0"}
    measured = simulate_top("continuous_motion", generics={"lanes_g": 1}, environment=environment)
    assert len(measured["answers"]) == 200


def test_top_flags_the_counts_they_belong_to_and_forgets_all_at_a_reset():
    simulate_top("end_of_the_trained_range", generics={"lanes_g": 20})  # a result per clock: no flag may be late


@pytest.mark.parametrize("lanes", [1, 4, 10])
def test_top_whose_axes_take_turns_flags_the_counts_they_belong_to(lanes):
    """As many as fit between two results: with a result held, with results on their way, and with none sharing."""
    simulate_top("flags_one_after_the_other", label="turns", generics={"lanes_g": lanes, "compensated_g": "true"})


@pytest.mark.parametrize("compensated", ["false", "true"])
def test_top_of_the_serial_form_equals_model_and_flags_the_counts_they_belong_to(compensated):
    """With a compensator that adds nothing, and without: currents are made in turn."""
    weights, generated = shipped_in("serial")
    generics = {"lanes_g": 1, "compensated_g": compensated}
    simulate_top("flags_one_after_the_other", label="serial flags", generics=generics,
                 environment={"WEIGHTS": str(weights)}, generated=generated)  # fmt: skip


def test_loadable_top_of_the_serial_form_is_refused():
    weights, generated = shipped_in("serial")
    with pytest.raises(AssertionError, match="gc_force_path: need loadable_g = false with a ROM of the form serial"):
        simulate_top("poses", label="serial loadable", generics={"lanes_g": 1, "loadable_g": "true"},
                     generated=generated, environment={"WEIGHTS": str(weights)})  # fmt: skip


def test_top_with_a_compensator_follows_a_short_motion(tmp_path):
    folder = compensated_weights(tmp_path)
    environment = {"POSES": "4", "START_S": "0.18", "WEIGHTS": str(folder)}
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


@walks_the_hierarchy
def test_motion_of_the_report_equals_the_model_and_leaves_a_waveform(tmp_path):
    """As `make sim` runs it, as a function that returns a value."""
    run = motion_run(RTL, tmp_path, weights_under_test(), tmp_path / "run.vcd", n_poses=6)
    np.testing.assert_array_equal(run.count, motion(MACHINE, 6, 0.18))
    model = fixed_network(), fixed_compensation()
    assert run.lsb(*model).max() == 0
    wrong = replace(run, force_mn=run.force_mn + np.array([0, 3, 0]))
    assert wrong.lsb(*model).max() == 3
    assert "| motion | 6 | 3 |" in error_table(wrong, *model, MACHINE)
    assert (tmp_path / "run.vcd").stat().st_size > 0
