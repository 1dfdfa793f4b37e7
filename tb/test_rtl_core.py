"""gc_core at every lanes_g: forces and flags equal the bit-true model; interval, latency, gaps, reset in mid-stream."""

import os
from unittest.mock import patch

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import fixed_network, pack, unpack
from gravcomp.core.formats import COUNT_BITS, FORCE_BITS, FixedNetwork
from gravcomp.twin import network as bittrue
from gravcomp_lab.benches.core import (
    LANES,
    OUTPUTS,
    CoreRun,
    back_to_back,  # noqa: F401, cocotb finds it here
    draw_counts,
    inputs_of,
    run_of,
)
from gravcomp_lab.benches.stream import start, stream
from runner import simulate


def assert_equal_to_model(recording, counts: np.ndarray) -> None:
    fixed = fixed_network()
    expected = bittrue.core(counts, fixed)
    n = fixed.n_axes
    np.testing.assert_array_equal(unpack(recording.outputs["out_force"], FORCE_BITS, n), expected.force_mn)
    np.testing.assert_array_equal(unpack(recording.outputs["out_clamped"], 1, n) != 0, expected.clamped)
    np.testing.assert_array_equal(unpack(recording.outputs["out_saturated"], 1, n) != 0, expected.saturated)


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
    steps, rng = lane_steps(fixed_network(), int(os.environ["LANES_G"])), np.random.default_rng(13)
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


def assert_run_is_right(run: CoreRun, lanes: int) -> None:
    """Interval and latency are exactly those of the header; nothing is lost or invented; all equals the model."""
    fixed = fixed_network()
    expected = bittrue.core(run.count, fixed)
    for name in ("force_mn", "clamped", "saturated"):
        np.testing.assert_array_equal(getattr(run, name), getattr(expected, name))
    assert run.interval == lane_steps(fixed, lanes)
    assert run.latency == core_latency(fixed, lanes)


def lane_steps(fixed: FixedNetwork, lanes: int) -> int:
    """Clocks of the lanes for all neurons."""
    return -(-fixed.n_hidden // lanes)


def core_latency(fixed: FixedNetwork, lanes: int) -> int:
    """Clocks from counts to forces, as the header of gc_core has them."""
    steps, n = lane_steps(fixed, lanes), fixed.n_axes
    is_once, is_serial = steps == 1, lanes == 1 and steps >= n
    trees = int(np.ceil(np.log2(fixed.n_inputs + 1))) + int(np.ceil(np.log2(lanes + is_once)))
    scaler = n if is_serial and n > 1 else 0  # a shared multiplier takes its clocks
    turns = int(fixed.is_turning.sum())
    wait = 11 + (turns if steps >= turns > 1 else 0) if turns else scaler
    extra = 3 if is_once else 2 if lanes == 1 else 0
    return 14 + steps + trees + extra + wait + scaler


def check_core(lanes: int, **options) -> None:
    """Simulate the core with all tests of this module, or those of another one."""
    module = options.pop("module", "test_rtl_core")
    generics = {"lanes_g": lanes, **options.pop("generics", {})}
    with patch.dict(os.environ, options.get("environment", {})):  # the machine under test, for the model too
        assert_run_is_right(run_of(simulate("gc_core", module, generics=generics, **options)), lanes)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", LANES)
def test_core_equals_model_at_its_interval_and_latency(lanes):
    check_core(lanes)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [1, 4])
def test_loadable_core_with_its_rom_has_the_same_interval_and_latency(lanes):
    check_core(lanes, generics={"loadable_g": "true"})
