"""gc_timeout equals its twin, and expires one clock after its limit."""

import cocotb
import numpy as np

from gravcomp.twin.timeout import timeout
from playback import assert_equal, play
from runner import simulate


@cocotb.test()
@cocotb.parametrize(limit=[0, 1, 7, 2**32 - 1])
async def expires_after_its_limit(dut, limit):
    restart = np.zeros(60, np.int64)
    restart[[5, 6, 20]] = 1
    got = await play(dut, {"restart": restart, "cfg_clocks": np.full(60, limit)}, ["expired"])
    quiet = np.arange(60 - 21)
    np.testing.assert_array_equal(got["expired"][21:], quiet > limit)


@cocotb.test()
async def random_restarts_and_limits(dut):
    rng = np.random.default_rng(51)
    n_clocks = 2000
    inputs = {
        "rst": (rng.random(n_clocks) < 0.01).astype(np.int64),
        "restart": (rng.random(n_clocks) < 0.1).astype(np.int64),
        "cfg_clocks": rng.integers(0, 12, n_clocks // 20).repeat(20),
    }
    got = await play(dut, inputs, ["expired"])
    assert_equal(got, {"expired": timeout(inputs["rst"] | inputs["restart"], inputs["cfg_clocks"])})
    assert 0.1 < got["expired"].mean() < 0.9


def test_timeout_equals_twin():
    simulate("gc_timeout", "test_rtl_timeout")
