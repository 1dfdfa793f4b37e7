"""gc_index_check equals its bit-true model; what it must tell is tested with gc_quad_decoder."""

import cocotb
import numpy as np

from gravcomp.twin.encoder import IndexCheck
from playback import assert_equal, play
from runner import simulate

MARK_CLOCKS = 6


@cocotb.test()
@cocotb.parametrize(period=[0, 8, 12, 2**32 - 4])
async def equals_bit_true_around_a_mark(dut, period):
    """A walk around a mark with marks where they belong, and now and then not."""
    rng = np.random.default_rng(7)
    cocotb.log.info("seed 7")
    n_clocks = 8000
    step = np.where(rng.random(n_clocks) < 0.15, rng.choice([-1, 1], n_clocks), 0)
    position = np.concatenate(([0], np.cumsum(step)[:-1]))
    of_mark = position % period if period else position
    inputs = {
        "rst": (rng.random(n_clocks) < 0.001).astype(np.int64),
        "step_valid": np.abs(step),
        "step_up": (step > 0).astype(np.int64),
        "in_home": ((rng.random(n_clocks) < 0.003) | (np.arange(n_clocks) == 0)).astype(np.int64),
        "in_referenced": (rng.random(n_clocks) < 0.995).astype(np.int64) * (np.arange(n_clocks) > 4),
        "in_phase": (position % 4 == 0).astype(np.int64),
        "in_z": ((of_mark == 0) ^ (rng.random(n_clocks) < 0.01)).astype(np.int64),
        "cfg_index_period": np.full(n_clocks, period),
    }
    check, expected = IndexCheck(MARK_CLOCKS), np.zeros(n_clocks, np.int64)
    for k in range(n_clocks - 1):
        levels = tuple(int(inputs[name][k]) for name in ("in_referenced", "in_phase", "in_z"))
        check.clock(int(inputs["rst"][k]), int(step[k]), int(inputs["in_home"][k]), levels, period)
        expected[k + 1] = check.out_lost
    assert expected.any()
    assert_equal(await play(dut, inputs, ("out_lost",)), {"out_lost": expected})


def test_index_check_equals_bit_true():
    simulate("gc_index_check", "test_rtl_index_check", generics={"mark_clocks_g": MARK_CLOCKS})
