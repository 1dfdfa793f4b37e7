"""gc_sin_cos: sine and cosine, bit-true at every phase."""

import cocotb
import numpy as np
import pytest

from codes import unpack
from gravcomp.core.formats import OPERAND_BITS, PHASE_BITS
from gravcomp.twin.sin_cos import sin_cos
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import simulate

SIN_COS_CLOCKS = 7


@cocotb.test()
async def every_phase(dut):
    code = np.arange(2**PHASE_BITS)
    await start(dut)
    got = await stream(dut, [{"in_phase": int(c)} for c in code], ["out_sin", "out_cos"])
    for name, expected in zip(("out_sin", "out_cos"), sin_cos(code), strict=True):
        np.testing.assert_array_equal(unpack(got.outputs[name], OPERAND_BITS, 1)[:, 0], expected)
    assert latencies(got) == {SIN_COS_CLOCKS}


@cocotb.test()
async def reset_in_mid_stream(dut):
    code, names = np.array([1000, 70000]), ["out_sin", "out_cos"]
    await start(dut)
    inputs = [{"in_phase": int(c)} for c in code]
    for got in await after_resets(dut, inputs, names, range(1, SIN_COS_CLOCKS + 3), flush_clocks=12):
        for name, expected in zip(names, sin_cos(code), strict=True):
            np.testing.assert_array_equal(unpack(got.outputs[name], OPERAND_BITS, 1)[:, 0], expected)


@pytest.mark.slow
def test_sin_cos_equals_model_at_every_phase():
    simulate("gc_sin_cos", "test_rtl_sin_cos", tests="every_phase")


def test_sin_cos_forgets_what_is_under_way_at_a_reset():
    simulate("gc_sin_cos", "test_rtl_sin_cos", tests="reset_in_mid_stream", label="reset")
