"""gc_core at every lanes_g: forces and flags equal the bit-true model; interval, latency, gaps, reset in mid-stream."""

import json
import os
import time

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import COUNT_BITS, FORCE_BITS
from gravcomp.twin import network as bittrue
from runner import BUILD, simulate
from stream import latencies, start, stream

LANES = [1, 2, 4, 5, 10, 20]
OUTPUTS = ["out_force", "out_clamped", "out_saturated"]


def draw_counts(n_poses: int, rng: np.random.Generator) -> np.ndarray:
    """Counts over the trained range, one in eight a corner of 32 bits or of the range."""
    fixed = fixed_network()
    shape = (n_poses, fixed.n_axes)
    counts = rng.integers(fixed.count_low, fixed.count_high, shape, endpoint=True)
    edges = rng.choice(
        np.concatenate([fixed.count_low + k for k in (-1, 0)] + [fixed.count_high + k for k in (0, 1)]), shape
    )
    odd = np.where(rng.random(shape) < 0.5, edges, corners_and_random(COUNT_BITS, shape, rng))
    return np.where(rng.random(shape) < 0.125, odd, counts)


def inputs_of(counts: np.ndarray) -> list[dict[str, int]]:
    return [{"in_count": pack(row, COUNT_BITS)} for row in counts]


def assert_equal_to_model(recording, counts: np.ndarray) -> None:
    fixed = fixed_network()
    expected = bittrue.core(counts, fixed)
    n = fixed.n_axes
    np.testing.assert_array_equal(unpack(recording.outputs["out_force"], FORCE_BITS, n), expected.force_mn)
    np.testing.assert_array_equal(unpack(recording.outputs["out_clamped"], 1, n) != 0, expected.clamped)
    np.testing.assert_array_equal(unpack(recording.outputs["out_saturated"], 1, n) != 0, expected.saturated)


@cocotb.test()
async def back_to_back(dut):
    """Interval and latency are exactly those of the header; nothing is lost or invented."""
    lanes, fixed = int(os.environ["LANES_G"]), fixed_network()
    steps = fixed.n_hidden // lanes
    counts = draw_counts(40 * min(lanes, 5), np.random.default_rng(10))
    await start(dut)
    began = time.perf_counter()
    got = await stream(dut, inputs_of(counts), OUTPUTS, has_ready=True)
    clocks_per_s = (got.valid[-1] + 1) / (time.perf_counter() - began)
    assert_equal_to_model(got, counts)
    assert set(np.diff(got.accepted)) == {steps}
    is_once = steps == 1
    trees = int(np.ceil(np.log2(fixed.n_axes + 1))) + int(np.ceil(np.log2(lanes + is_once)))
    in_turn = 2 * fixed.n_axes if fixed.n_axes > 1 else 0  # clocks of the shared multipliers
    extra = 3 if is_once else in_turn + 2 if lanes == 1 else 0
    (latency,) = latencies(got)
    assert latency == 14 + steps + trees + extra
    measured = {"lanes": lanes, "interval": steps, "latency": latency, "simulated_clocks_per_s": round(clocks_per_s)}
    (BUILD / f"core-{fixed.n_axes}-{fixed.n_hidden}-{lanes}.json").write_text(json.dumps(measured))


@cocotb.test()
async def random_gaps(dut):
    """A run with gaps gives the same forces as one without."""
    rng = np.random.default_rng(11)
    counts = draw_counts(60, rng)
    await start(dut)
    got = await stream(dut, inputs_of(counts), OUTPUTS, gap_probability=0.9, rng=rng, has_ready=True)
    assert_equal_to_model(got, counts)
    assert len(set(np.diff(got.accepted))) > 3, "the gaps did not vary"


@cocotb.test()
async def ready_at_its_interval(dut):
    """in_ready is low from each accepted input until the interval is over, and never else: neither late nor early."""
    steps, rng = fixed_network().n_hidden // int(os.environ["LANES_G"]), np.random.default_rng(13)
    await start(dut)
    since_accepted = steps
    for _ in range(40 * steps):
        ready = int(dut.in_ready.value)
        assert ready == (since_accepted >= steps)
        dut.in_valid.value = offers = int(rng.random() < 0.3)
        since_accepted = 1 if offers and ready else since_accepted + 1
        await FallingEdge(dut.clk)


@cocotb.test()
async def reset_in_mid_stream(dut):
    """Whatever is under way at a reset never comes out; what follows is right."""
    rng = np.random.default_rng(12)
    await start(dut)
    for clocks_before_reset in [1, 2, *rng.integers(3, 60, 10)]:
        dut.in_count.value = pack(draw_counts(1, rng)[0], COUNT_BITS)
        dut.in_valid.value = 1
        for _ in range(int(clocks_before_reset)):
            await FallingEdge(dut.clk)
        dut.in_valid.value = 0
        dut.rst.value = 1
        await FallingEdge(dut.clk)
        assert dut.out_valid.value == 0
        assert dut.in_ready.value == 1
        dut.rst.value = 0
        counts = draw_counts(3, rng)
        got = await stream(dut, inputs_of(counts), OUTPUTS, has_ready=True)
        assert_equal_to_model(got, counts)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", LANES)
def test_core_equals_model_at_its_interval_and_latency(lanes):
    simulate("gc_core", "test_rtl_core", generics={"lanes_g": lanes})


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [1, 4])
def test_loadable_core_with_its_rom_has_the_same_interval_and_latency(lanes):
    simulate("gc_core", "test_rtl_core", generics={"lanes_g": lanes, "loadable_g": "true"})
