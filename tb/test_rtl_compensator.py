"""gc_compensator equals its bit-true model at its latency, is transparent without constants, and is quiet at rest."""

import os
from pathlib import Path

import cocotb
import numpy as np
import pytest

from codes import ROOT, corners_and_random, fixed_network, pack, unpack
from compensated import CSV, N_AXES, compensated_weights, constants, draw_periods
from gravcomp.core.cost import compensator_clocks
from gravcomp.core.formats import COUNT_BITS, FORCE_BITS
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator, friction
from gravcomp_lab.benches.force_path import Bench
from gravcomp_lab.benches.stream import latencies, start, stream
from runner import BUILD, simulate

OUTPUTS = ["out_force", "out_saturated"]
PACE = 6  # clocks per encoder edge: the force is there before the speed is known
WEIGHTS = BUILD / "compensated"


def in_turn() -> int:
    """Axes that share a unit; results may then follow each other after as many clocks."""
    return int(os.environ["TURNS_G"])


def draw(n: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces, counts and periods (n, axes), each with its corners."""
    shape = (n, N_AXES)
    large = corners_and_random(FORCE_BITS, shape, rng)
    force = np.where(rng.random(shape) < 0.3, large, rng.integers(-130_000, 130_000, shape))
    count = np.where(
        rng.random(shape) < 0.3, corners_and_random(COUNT_BITS, shape, rng), rng.integers(-160_000, 160_000, shape)
    )
    return force, count, draw_periods(shape, rng)


def words(force, count, period) -> list[dict[str, int]]:
    return [
        {"in_force": pack(f, FORCE_BITS), "in_count": pack(c, COUNT_BITS), "in_period": pack(p, 32)}
        for f, c, p in zip(force, count, period, strict=True)
    ]


def assert_equal_to_model(recording, force, count, period) -> np.ndarray:
    """Returns whether each force saturated."""
    _, fixed = constants(Path(os.environ["WEIGHTS"]))
    expected, saturated = compensator(force, count, period, fixed)
    np.testing.assert_array_equal(unpack(recording.outputs["out_force"], FORCE_BITS, N_AXES), expected)
    np.testing.assert_array_equal(unpack(recording.outputs["out_saturated"], 1, N_AXES) != 0, saturated)
    return saturated


@cocotb.test()
async def back_to_back(dut):
    inputs = draw(600, np.random.default_rng(31))
    await start(dut)
    got = await stream(dut, words(*inputs), OUTPUTS, spacing=in_turn())
    saturated = assert_equal_to_model(got, *inputs)
    assert saturated.any(), "nothing saturated: the corners were not reached"
    assert latencies(got) == {compensator_clocks(in_turn())}


@cocotb.test()
async def random_gaps_and_resets(dut):
    rng = np.random.default_rng(32)
    await start(dut)
    for _ in range(5):
        inputs = draw(20, rng)
        options = {"spacing": in_turn(), "gap_probability": 0.7, "rng": rng}
        got = await stream(dut, words(*inputs), OUTPUTS, **options)
        assert_equal_to_model(got, *inputs)
        under_way = words(*draw(int(rng.integers(1, compensator_clocks(in_turn()))), rng))
        await stream(dut, under_way, OUTPUTS, spacing=in_turn(), flush_clocks=int(rng.integers(0, in_turn())))
        dut.in_valid.value = 0
        dut.rst.value = 1
        await cocotb.triggers.FallingEdge(dut.clk)
        dut.rst.value = 0


@cocotb.test()
async def transparent(dut):
    force, count, period = draw(300, np.random.default_rng(33))
    await start(dut)
    got = await stream(dut, words(force, count, period), OUTPUTS, spacing=in_turn())
    np.testing.assert_array_equal(unpack(got.outputs["out_force"], FORCE_BITS, N_AXES), force)
    assert not any(got.outputs["out_saturated"])
    assert latencies(got) == {compensator_clocks(in_turn())}


async def added_mn(bench: Bench) -> np.ndarray:
    """One inference: what the top adds to the network's forces, mN."""
    count, _, force, *_ = await bench.infer()
    network = bittrue.core(unpack([count], COUNT_BITS, N_AXES)[0], fixed_network()).force_mn
    return unpack([force], FORCE_BITS, N_AXES)[0] - network


@cocotb.test()
async def motion_reversal_and_rest(dut):
    """Friction of its direction at a steady pace, none at a reversal, and none at rest, dither included."""
    _, fixed = constants(Path(os.environ["WEIGHTS"]))
    bench, period = Bench(dut), 4 * PACE
    await bench.start()
    dut.clocks_per_edge.value = PACE
    for direction in (1, -1):
        dut.target.value = pack([direction * 10_000] * N_AXES, COUNT_BITS)
        # When the force reaches the compensator, fewer than five edges have been decoded: the speed is not yet known.
        np.testing.assert_array_equal(await added_mn(bench), 0)
        await bench.clocks(3 * period)
        for _ in range(2):
            expected = friction(np.zeros(N_AXES, int), np.full(N_AXES, direction * period), fixed)
            np.testing.assert_array_equal(await added_mn(bench), expected)
    here = unpack([int(dut.sts_count.value)], COUNT_BITS, N_AXES)[0]
    dut.target.value = pack(here, COUNT_BITS)
    fading = [np.abs(await added_mn(bench)) for _ in range(8)]
    assert (np.diff(fading, axis=0) <= 0).all(), "friction must only fade when the axis stops"
    for k in range(40):
        dut.target.value = pack(here + k % 2, COUNT_BITS)
        await bench.clocks(int(k % 7))
        np.testing.assert_array_equal(await added_mn(bench), 0)


@pytest.mark.parametrize("turns", [1, 3])
@pytest.mark.parametrize("test", ["back_to_back", "random_gaps_and_resets"])
def test_compensator_equals_model(test, turns):
    """With a unit per axis, and with one whose tables and multipliers all axes take in turn."""
    folder = compensated_weights(WEIGHTS / "rich")
    simulate(
        "gc_compensator",
        "test_rtl_compensator",
        generics={"turns_g": turns},
        tests=f"{test}$",
        label=f"rich_{test}",
        generated=folder / "generated",
        environment={"WEIGHTS": str(folder)},
    )


@pytest.mark.parametrize("turns", [1, 3])
def test_compensator_is_transparent_without_constants(turns):
    simulate("gc_compensator", "test_rtl_compensator", generics={"turns_g": turns}, tests="transparent$",
             label="transparent")  # fmt: skip


def test_top_adds_friction_in_motion_and_nothing_at_rest():
    without_load_and_table = "\n".join(row for row in CSV.splitlines() if ",mu," not in row and ",a" not in row)
    folder = compensated_weights(WEIGHTS / "friction", without_load_and_table)
    simulate(
        "gc_force_path_bench",
        "test_rtl_compensator",
        generics={"lanes_g": 4},
        tests="motion_reversal_and_rest$",
        label="friction",
        generated=folder / "generated",
        environment={"WEIGHTS": str(folder)},
        extra_sources=tuple(
            ROOT / "tb" / "hdl" / f"{name}.vhd" for name in ("gc_encoder_model", "gc_force_path_bench")
        ),
    )
