"""gc_core at every lanes_g, and gc_core_serial: equal to the bit-true model; interval, latency, gaps, reset."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import fixed_network, pack
from gravcomp.core.formats import COUNT_BITS
from gravcomp_lab.benches.core import (
    LANES,
    OUTPUTS,
    back_to_back,  # noqa: F401, cocotb finds it here
    draw_counts,
    flush_clocks,
    inputs_of,
)
from gravcomp_lab.benches.stream import start, stream
from machines import shipped_in
from support.core import assert_equal_to_model, check_core, interval


@cocotb.test()
async def random_gaps(dut):
    """A run with gaps gives the same forces as one without."""
    rng = np.random.default_rng(11)
    counts = draw_counts(60, rng)
    await start(dut)
    options = {"has_ready": True, "flush_clocks": flush_clocks()}
    got = await stream(dut, inputs_of(counts), OUTPUTS, gap_probability=0.9, rng=rng, **options)
    assert_equal_to_model(got, counts)
    assert len(set(np.diff(got.accepted))) > 3, "the gaps did not vary"


@cocotb.test()
async def ready_at_its_interval(dut):
    """in_ready is low from each accepted input until the interval is over, and never else: neither late nor early."""
    steps, rng = interval(fixed_network(), int(os.environ["LANES_G"])), np.random.default_rng(13)
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
    latest = max(60, interval(fixed_network(), int(os.environ["LANES_G"])))
    for clocks_before_reset in [1, 2, *rng.integers(3, latest, 10)]:
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
        got = await stream(dut, inputs_of(counts), OUTPUTS, has_ready=True, flush_clocks=flush_clocks())
        assert_equal_to_model(got, counts)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", LANES)
def test_core_equals_model_at_its_interval_and_latency(lanes):
    check_core(lanes)


@pytest.mark.slow
@pytest.mark.parametrize(("lanes", "loadable"), [(1, "false"), (4, "false"), (20, "false"), (1, "true"), (4, "true")])
def test_lean_core_equals_model_at_its_interval_and_latency(lanes, loadable):
    """17 clocks with 4 lanes, 30 with one, 19 with 20, an inference in every clock."""
    weights, generated = shipped_in("lean")
    environment, generics = {"WEIGHTS": str(weights)}, {"loadable_g": loadable}
    check_core(lanes, environment=environment, generated=generated, label="lean", generics=generics)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [1, 4])
def test_loadable_core_with_its_rom_has_the_same_interval_and_latency(lanes):
    check_core(lanes, generics={"loadable_g": "true"})
