"""gc_multiply: the exact product, at its latency, at several widths."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, pack, unpack
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate


@cocotb.test()
async def product_is_exact(dut):
    a_bits, b_bits = int(os.environ["A_BITS_G"]), int(os.environ["B_BITS_G"])
    rng = np.random.default_rng(1)
    a = corners_and_random(a_bits, (500, 1), rng)
    b = corners_and_random(b_bits, (500, 1), rng)
    inputs = [{"in_a": pack(x, a_bits), "in_b": pack(y, b_bits)} for x, y in zip(a, b, strict=True)]
    await start(dut)
    got = await stream(dut, inputs, ["out_product"], gap_probability=0.3, rng=rng)
    np.testing.assert_array_equal(unpack(got.outputs["out_product"], a_bits + b_bits, 1), a * b)
    assert latencies(got) == {2}


@cocotb.test()
async def reset_in_mid_stream(dut):
    await start(dut)
    for got in await after_resets(dut, [{"in_a": 1, "in_b": b} for b in (1, 2)], ["out_product"], range(1, 4)):
        assert got.outputs["out_product"] == [1, 2]


@pytest.mark.parametrize(("a_bits", "b_bits"), [(18, 18), (24, 18), (2, 3)])
def test_multiply_equals_exact_product(a_bits, b_bits):
    simulate("gc_multiply", "test_rtl_multiply", generics={"a_bits_g": a_bits, "b_bits_g": b_bits})
