"""gc_output_scaler: saturation and scale to mN, bit-true, with n multipliers and with one."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.network.bittrue import output_scaler
from gravcomp.network.quantise import FORCE_BITS, OPERAND_BITS
from runner import simulate
from stream import latencies, start, stream


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


@pytest.mark.parametrize("serial", ["false", "true"])
def test_output_scaler_equals_model(serial):
    simulate("gc_output_scaler", "test_rtl_output_scaler", generics={"serial_g": serial})
