"""gc_output_scaler: saturation and scale to mN, bit-true, with n multipliers and with one."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import FORCE_BITS, OPERAND_BITS
from gravcomp.twin.network import output_scaler
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate


@cocotb.test()
async def sums_inside_and_beyond(dut):
    fixed, is_serial = fixed_network(), os.environ["SERIAL_G"] == "true"
    n, rng = fixed.n_axes, np.random.default_rng(6)
    edge = 2 ** (OPERAND_BITS - 1) << fixed.output_drop
    at_edge = np.array([[sign * edge + k] * n for sign in (-1, 1) for k in (-1, 0, 1)])
    totals = np.concatenate(
        [at_edge, corners_and_random(fixed.output_sum_bits, (150, n), rng), rng.integers(-edge, edge, (150, n))]
    )
    await start(dut)
    got = await stream(
        dut,
        [{"in_total": pack(row, fixed.output_sum_bits)} for row in totals],
        ["out_force", "out_saturated"],
        spacing=n if is_serial else 1,
        gap_probability=0.2,
        rng=rng,
    )
    force_mn, is_saturated = output_scaler(totals, fixed)
    np.testing.assert_array_equal(unpack(got.outputs["out_force"], FORCE_BITS, n), force_mn)
    np.testing.assert_array_equal(unpack(got.outputs["out_saturated"], 1, n) != 0, is_saturated)
    assert is_saturated.any()
    assert not is_saturated.all()
    assert latencies(got) == {n + 3 if is_serial else 3}
    assert int(dut.out_force.value) == got.outputs["out_force"][-1], "the result did not hold"


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed, is_serial = fixed_network(), os.environ["SERIAL_G"] == "true"
    n = fixed.n_axes
    values = 1000 * np.arange(1, 3 * n + 1).reshape(3, n) << fixed.output_drop
    inputs = [{"in_total": pack(row, fixed.output_sum_bits)} for row in values]
    options = {"spacing": n if is_serial else 1, "flush_clocks": 16}
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_force"], range(1, 2 * n + 5), **options):
        np.testing.assert_array_equal(unpack(got.outputs["out_force"], FORCE_BITS, n), output_scaler(values, fixed)[0])


@pytest.mark.parametrize("serial", ["false", "true"])
def test_output_scaler_equals_model(serial):
    simulate("gc_output_scaler", "test_rtl_output_scaler", generics={"serial_g": serial})
