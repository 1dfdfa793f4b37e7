"""gc_current_scaler: currents through 1/K_t, bit-true, and within half a microampere and its constant's rounding."""

import cocotb
import numpy as np

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import CURRENT_BITS, FORCE_BITS
from gravcomp.facts import CURRENT_SCALER_CLOCKS
from gravcomp.twin.network import current_scaler
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from machines import MACHINE
from runner import simulate


@cocotb.test()
async def random_forces(dut):
    fixed, rng = fixed_network(), np.random.default_rng(7)
    force_mn = corners_and_random(FORCE_BITS, (400, fixed.n_axes), rng)
    await start(dut)
    inputs = [{"in_force": pack(row, FORCE_BITS)} for row in force_mn]
    got = await stream(dut, inputs, ["out_current"], gap_probability=0.2, rng=rng)
    current_ua = unpack(got.outputs["out_current"], CURRENT_BITS, fixed.n_axes)
    np.testing.assert_array_equal(current_ua, current_scaler(force_mn, fixed))
    assert latencies(got) == {CURRENT_SCALER_CLOCKS}
    exact_ua = force_mn * 1000.0 / MACHINE.drive.effort_per_ampere
    constant_error = 0.5 / fixed.current_scale  # the factor is rounded to its last bit
    assert (np.abs(current_ua - exact_ua) <= 0.5 + np.abs(exact_ua) * constant_error).all()


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed = fixed_network()
    force_mn = 1000 * np.arange(1, 3 * fixed.n_axes + 1).reshape(3, fixed.n_axes)
    inputs = [{"in_force": pack(row, FORCE_BITS)} for row in force_mn]
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_current"], range(1, 6), flush_clocks=8):
        current_ua = unpack(got.outputs["out_current"], CURRENT_BITS, fixed.n_axes)
        np.testing.assert_array_equal(current_ua, current_scaler(force_mn, fixed))


def test_current_scaler_equals_model():
    simulate("gc_current_scaler", "test_rtl_current_scaler")
