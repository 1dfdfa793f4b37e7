"""gc_input_scaler: clamp and scale of encoder counts, bit-true, with n multipliers and with one."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import COUNT_BITS, OPERAND_BITS
from gravcomp.twin.network import input_scaler
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate


@cocotb.test()
async def corners_and_random_counts(dut):
    fixed, is_serial = fixed_network(), os.environ["SERIAL_G"] == "true"
    n, rng = fixed.n_axes, np.random.default_rng(3)
    inside = rng.integers(fixed.count_low, fixed.count_high, (300, n), endpoint=True)
    edges = np.concatenate([np.arange(-3, 4)[:, None] + edge for edge in (fixed.count_low, fixed.count_high)])
    counts = np.concatenate([corners_and_random(COUNT_BITS, (100, n), rng), edges, inside])
    await start(dut)
    got = await stream(
        dut,
        [{"in_count": pack(row, COUNT_BITS)} for row in counts],
        ["out_x", "out_clamped"],
        spacing=n if is_serial else 1,
        gap_probability=0.2,
        rng=rng,
    )
    x, is_clamped = input_scaler(counts, fixed)
    np.testing.assert_array_equal(unpack(got.outputs["out_x"], OPERAND_BITS, n), x)
    np.testing.assert_array_equal(unpack(got.outputs["out_clamped"], 1, n) != 0, is_clamped)
    assert latencies(got) == {n + 3 if is_serial else 3}
    assert int(dut.out_x.value) == got.outputs["out_x"][-1], "the result did not hold"


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed, is_serial = fixed_network(), os.environ["SERIAL_G"] == "true"
    n = fixed.n_axes
    values = 1000 * np.arange(1, 3 * n + 1).reshape(3, n)
    inputs = [{"in_count": pack(row, COUNT_BITS)} for row in values]
    options = {"spacing": n if is_serial else 1, "flush_clocks": 16}
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_x"], range(1, 2 * n + 5), **options):
        np.testing.assert_array_equal(unpack(got.outputs["out_x"], OPERAND_BITS, n), input_scaler(values, fixed)[0])


@pytest.mark.parametrize("serial", ["false", "true"])
def test_input_scaler_equals_model(serial):
    simulate("gc_input_scaler", "test_rtl_input_scaler", generics={"serial_g": serial})
