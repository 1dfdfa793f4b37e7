"""gc_output_layer: output sums over all lanes and steps, bit-true, bias included once."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import OPERAND_BITS
from gravcomp.twin.network import output_layer
from gravcomp_lab.benches.stream import after_resets, start, stream
from runner import simulate


@cocotb.test()
async def sums_of_random_activations(dut):
    fixed, lanes = fixed_network(), int(os.environ["LANES_G"])
    steps, rng = fixed.n_hidden // lanes, np.random.default_rng(5)
    h = corners_and_random(OPERAND_BITS, (60, fixed.n_hidden), rng)
    inputs = [{"in_h": pack(row, OPERAND_BITS)} for row in h.reshape(-1, lanes)]
    await start(dut)
    got = await stream(dut, inputs, ["out_total"], gap_probability=0.2, rng=rng)
    totals = unpack(got.outputs["out_total"], fixed.output_sum_bits, fixed.n_axes)
    np.testing.assert_array_equal(totals, output_layer(h, fixed))
    last_of_inference = got.accepted[steps - 1 :: steps]
    delays = {out - last for last, out in zip(last_of_inference, got.valid, strict=True)}
    assert delays == {3 + int(lanes == 1) + int(np.ceil(np.log2(lanes + (steps == 1))))}


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed, lanes = fixed_network(), int(os.environ["LANES_G"])
    h = 1000 * np.arange(1, fixed.n_hidden + 1)
    inputs = [{"in_h": pack(row, OPERAND_BITS)} for row in h.reshape(-1, lanes)]
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_total"], range(1, len(inputs) + 6), flush_clocks=16):
        totals = unpack(got.outputs["out_total"], fixed.output_sum_bits, fixed.n_axes)
        np.testing.assert_array_equal(totals, [output_layer(h, fixed)])


@pytest.mark.parametrize("lanes", [1, 2, 4, 5, 10, 20])
def test_output_layer_equals_model(lanes):
    simulate("gc_output_layer", "test_rtl_output_layer", generics={"lanes_g": lanes})
