"""gc_hidden_lane: pre-activations of the neurons of one lane, in turn, bit-true."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import OPERAND_BITS
from gravcomp.twin.network import hidden_lane
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate


@cocotb.test()
async def neurons_in_turn(dut):
    fixed, lanes, lane = fixed_network(), int(os.environ["LANES_G"]), int(os.environ["LANE_G"])
    steps, rng = fixed.n_hidden // lanes, np.random.default_rng(4)
    x = np.clip(corners_and_random(OPERAND_BITS, (20, fixed.n_inputs), rng), fixed.x_low, fixed.x_high)
    inputs = [{"in_x": pack(row, OPERAND_BITS)} for row in np.repeat(x, steps, axis=0)]
    await start(dut)
    got = await stream(dut, inputs, ["out_a"], gap_probability=0.2, rng=rng)
    expected = hidden_lane(x, fixed)[:, lane::lanes].reshape(-1)
    np.testing.assert_array_equal(unpack(got.outputs["out_a"], OPERAND_BITS, 1)[:, 0], expected)
    assert np.abs(expected).max() > 2 ** (OPERAND_BITS - 1) - 2, "no pre-activation saturated: the test is too tame"
    assert latencies(got) == {3 + int(lanes == 1) + int(np.ceil(np.log2(fixed.n_inputs + 1)))}


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed, lanes, lane = fixed_network(), int(os.environ["LANES_G"]), int(os.environ["LANE_G"])
    steps = fixed.n_hidden // lanes
    x = 1000 * np.arange(1, fixed.n_inputs + 1)
    inputs = [{"in_x": pack(x, OPERAND_BITS)}] * steps
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_a"], range(1, 8), flush_clocks=16):
        a = unpack(got.outputs["out_a"], OPERAND_BITS, 1)[:, 0]
        np.testing.assert_array_equal(a, hidden_lane(x, fixed)[lane::lanes])


@pytest.mark.parametrize(("lanes", "lane"), [(1, 0), (4, 3), (5, 2), (10, 7)])
def test_hidden_lane_equals_model(lanes, lane):
    simulate("gc_hidden_lane", "test_rtl_hidden_lane", generics={"lanes_g": lanes, "lane_g": lane})
