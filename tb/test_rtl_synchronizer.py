"""gc_synchronizer equals its bit-true model: latency, and no valid before the chain is filled."""

import os

import cocotb
import numpy as np
import pytest

from gravcomp.twin.encoder import synchronizer
from playback import assert_equal, play
from runner import simulate


@cocotb.test()
@cocotb.parametrize(reset=[False, True])
async def equals_bit_true(dut, reset):
    rng = np.random.default_rng(3)
    cocotb.log.info("seed 3")
    stages = int(os.environ["STAGES_G"])
    inputs = {"rst": (rng.random(400) < 0.05).astype(np.int64), "async_data": rng.integers(-4, 4, 400)}
    recorded = await play(dut, inputs, ("out_valid", "out_data"), reset=reset)
    valid, data = synchronizer(inputs["rst"], inputs["async_data"], stages)
    assert_equal({"out_valid": recorded["out_valid"]}, {"out_valid": valid})
    assert np.array_equal(recorded["out_data"][stages:], inputs["async_data"][:-stages])
    assert np.array_equal(recorded["out_data"][stages:], data[stages:])
    assert reset or not recorded["out_data"][:stages].any()


@pytest.mark.parametrize("stages", [2, 3])
def test_synchronizer_equals_bit_true(stages):
    simulate("gc_synchronizer", "test_rtl_synchronizer", generics={"width_g": 3, "stages_g": stages})
