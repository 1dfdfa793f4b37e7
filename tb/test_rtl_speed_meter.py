"""gc_speed_meter equals its bit-true model."""

import os

import cocotb
import numpy as np
import pytest

from gravcomp.twin.encoder import speed_meter
from playback import assert_equal, play
from runner import simulate

OUTPUTS = ("speed_valid", "speed_zero", "speed_period")


def steps(rng: np.random.Generator, timeout: int) -> dict[str, np.ndarray]:
    """Bursts of counts at many speeds, with reversals, lost counts, pauses around the time-out and resets.

    Many times longer than the period counter of a small time-out, which wraps.
    """
    gaps = np.concatenate([rng.integers(1, rng.integers(2, timeout + 4), 12) for _ in range(60)])
    at = np.cumsum(gaps)
    n_clocks = at[-1] + 2 * timeout
    inputs = {name: np.zeros(n_clocks, np.int64) for name in ("rst", "step_valid", "step_up", "step_lost")}
    inputs["step_valid"][at] = 1
    inputs["step_up"][:] = np.cumsum(rng.random(n_clocks) < 0.2 / timeout) % 2
    inputs["step_lost"][:] = (rng.random(n_clocks) < 0.2 / timeout) & (inputs["step_valid"] == 0)
    inputs["rst"][:] = rng.random(n_clocks) < 0.1 / timeout
    return inputs


@cocotb.test()
@cocotb.parametrize(seed=[5, 6, 7])
async def equals_bit_true(dut, seed):
    cocotb.log.info("seed %d", seed)
    timeout = int(os.environ["TIMEOUT_G"])
    inputs = steps(np.random.default_rng(seed), timeout)
    recorded = await play(dut, inputs, OUTPUTS, reset=seed > 5)
    assert_equal(recorded, speed_meter(*inputs.values(), timeout))


@pytest.mark.parametrize("timeout", [1, 40])
def test_speed_meter_equals_bit_true(timeout):
    simulate("gc_speed_meter", "test_rtl_speed_meter", generics={"timeout_g": timeout})


def test_speed_meter_refuses_timeout():
    with pytest.raises(AssertionError, match="gc_speed_meter: need timeout_g < 536870912, got 536870912"):
        simulate("gc_speed_meter", "test_rtl_speed_meter", generics={"timeout_g": 2**29})
