"""gc_wide_multiply: the product, or its lowest bits, of operands of one part, of several, and of the widths in use."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, pack
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate

# Widths of operands and product, and the products of parts of up to 17 bits and a sign that reach it.
WIDTHS = [
    (18, 18, 36, 1),
    (12, 7, 9, 1),
    (24, 18, 42, 2),  # gc_current_scaler
    (18, 19, 37, 2),
    (25, 18, 43, 2),  # gc_friction
    (32, 25, 32, 3),  # gc_position_table: the product of the highest parts lies above what is kept
    (32, 25, 57, 4),
    (52, 18, 70, 3),
    (36, 35, 71, 6),
]


@cocotb.test()
async def product_is_exact(dut):
    a_bits, b_bits, bits = (int(os.environ[f"{name}_BITS_G"]) for name in ("A", "B", "PRODUCT"))
    rng = np.random.default_rng(3)
    a = corners_and_random(a_bits, (300, 1), rng)
    b = corners_and_random(b_bits, (300, 1), rng)
    inputs = [{"in_a": pack(x, a_bits), "in_b": pack(y, b_bits)} for x, y in zip(a, b, strict=True)]
    await start(dut)
    got = await stream(dut, inputs, ["out_product"], gap_probability=0.3, rng=rng)
    expected = [int(x) * int(y) % 2**bits for x, y in zip(a[:, 0], b[:, 0], strict=True)]
    assert got.outputs["out_product"] == expected
    levels = (int(os.environ["TERMS"]) - 1).bit_length()
    assert latencies(got) == {2 + levels}


@cocotb.test()
async def reset_in_mid_stream(dut):
    await start(dut)
    for got in await after_resets(dut, [{"in_a": 1, "in_b": b} for b in (1, 2)], ["out_product"], range(1, 7)):
        assert got.outputs["out_product"] == [1, 2]


@pytest.mark.parametrize(("a_bits", "b_bits", "product_bits", "terms"), WIDTHS)
def test_wide_multiply_equals_exact_product(a_bits, b_bits, product_bits, terms):
    simulate(
        "gc_wide_multiply",
        "test_rtl_wide_multiply",
        generics={"a_bits_g": a_bits, "b_bits_g": b_bits, "product_bits_g": product_bits},
        environment={"TERMS": str(terms)},
    )
