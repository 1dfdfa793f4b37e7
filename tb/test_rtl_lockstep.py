"""gc_lockstep equals its twin: copies that differ are seen a clock later, equal ones never."""

import os

import cocotb
import numpy as np
import pytest

from gravcomp.twin.lockstep import lockstep
from playback import assert_equal, play
from runner import simulate

WIDTH = 31


def lag() -> int:
    return int(os.environ["LAG_G"])


def copies(n_clocks: int, seed: int) -> dict[str, np.ndarray]:
    """Random outputs of a circuit and of its copy, which is behind; reset till the first of them has arrived."""
    rng = np.random.default_rng(seed)
    cocotb.log.info("seed %d", seed)
    main = rng.integers(0, 2**WIDTH, n_clocks)
    behind = np.concatenate([np.zeros(lag(), np.int64), main[: -lag()]])
    return {"rst": (np.arange(n_clocks) <= lag()).astype(np.int64), "in_main": main, "in_twin": behind}


@cocotb.test()
async def every_single_bit_is_seen(dut):
    """Each bit of either copy in turn is wrong for one clock: seen in the next, once."""
    inputs = copies(17 * WIDTH, 91)
    bits, at = 1 << np.arange(WIDTH), 8 * np.arange(WIDTH) + 5
    inputs["in_twin"][at] ^= bits
    inputs["in_main"][8 * WIDTH + at] ^= bits
    got = await play(dut, inputs, ("out_differ",))
    np.testing.assert_array_equal(np.flatnonzero(got["out_differ"]), [*(at + 1), *(8 * WIDTH + at + lag() + 1)])
    assert_equal(got, {"out_differ": lockstep(**inputs, lag=lag())})


@cocotb.test()
async def random_differences_and_resets(dut):
    inputs, rng = copies(2000, 92), np.random.default_rng(93)
    inputs["in_twin"] ^= np.where(rng.random(2000) < 0.2, rng.integers(0, 2**WIDTH, 2000), 0)
    inputs["rst"] |= (rng.random(2000) < 0.1).astype(np.int64)
    got = await play(dut, inputs, ("out_differ",))
    assert_equal(got, {"out_differ": lockstep(**inputs, lag=lag())})
    assert 0.1 < got["out_differ"].mean() < 0.25


@pytest.mark.parametrize("lag_g", [1, 3])
def test_lockstep_equals_twin(lag_g):
    simulate("gc_lockstep", "test_rtl_lockstep", generics={"bits_g": WIDTH, "lag_g": lag_g})
