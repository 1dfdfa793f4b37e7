"""gc_adder_tree: the exact n-ary sum, one clock per level of adders, and one for the terms if wanted."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, pack, unpack
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate

BITS = 24


@cocotb.test()
async def sum_is_exact(dut):
    n_terms = int(os.environ["TERMS_G"])
    rng = np.random.default_rng(2)
    # Terms of five bits less: no partial sum of up to 32 terms overflows.
    terms = corners_and_random(BITS - 5, (300, n_terms), rng)
    await start(dut)
    got = await stream(dut, [{"in_terms": pack(row, BITS)} for row in terms], ["out_sum"], gap_probability=0.3, rng=rng)
    np.testing.assert_array_equal(unpack(got.outputs["out_sum"], BITS, 1)[:, 0], terms.sum(axis=1))
    assert latencies(got) == {int(os.environ["TERM_CLOCKS_G"]) + int(np.ceil(np.log2(n_terms)))}


@cocotb.test()
async def reset_in_mid_stream(dut):
    n_terms = int(os.environ["TERMS_G"])
    await start(dut)
    inputs = [{"in_terms": pack([k] * n_terms, BITS)} for k in range(3)]
    for got in await after_resets(dut, inputs, ["out_sum"], range(1, 7)):
        assert got.outputs["out_sum"] == [0, n_terms, 2 * n_terms]


@pytest.mark.parametrize(("n_terms", "term_clocks"), [(1, 1), (2, 0), (3, 1), (4, 0), (5, 1), (20, 1)])
def test_adder_tree_equals_exact_sum(n_terms, term_clocks):
    generics = {"terms_g": n_terms, "bits_g": BITS, "term_clocks_g": term_clocks}
    simulate("gc_adder_tree", "test_rtl_adder_tree", generics=generics)
