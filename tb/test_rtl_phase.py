"""gc_phase: the phase of any count with any steps, bit-true."""

import cocotb
import numpy as np

from codes import corners_and_random, pack
from gravcomp.core.formats import COUNT_BITS, STEP_BITS
from gravcomp.twin.sin_cos import phase
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate

PHASE_CLOCKS = 6


def phase_inputs(count, coarse, fine):
    names = {"in_count": COUNT_BITS, "coarse_step": STEP_BITS, "fine_step": STEP_BITS}
    rows = zip(count, coarse, fine, strict=True)
    return [{name: pack([v], bits) for v, (name, bits) in zip(row, names.items(), strict=True)} for row in rows]


@cocotb.test()
async def corners_and_random_counts(dut):
    rng = np.random.default_rng(31)
    count = corners_and_random(COUNT_BITS, (1500,), rng)
    coarse, fine = (corners_and_random(STEP_BITS, (1500,), rng) for _ in range(2))
    await start(dut)
    got = await stream(dut, phase_inputs(count, coarse, fine), ["out_phase"], gap_probability=0.2, rng=rng)
    np.testing.assert_array_equal(got.outputs["out_phase"], phase(count, coarse, fine))
    assert latencies(got) == {PHASE_CLOCKS}


@cocotb.test()
async def reset_in_mid_stream(dut):
    count, step = np.array([70000, -3]), np.array([2**33 + 5, -(2**30)])
    inputs = phase_inputs(count, step, step)
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_phase"], range(1, PHASE_CLOCKS + 3), flush_clocks=12):
        np.testing.assert_array_equal(got.outputs["out_phase"], phase(count, step, step))


def test_phase_equals_model():
    simulate("gc_phase", "test_rtl_phase")
