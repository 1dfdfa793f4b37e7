"""gc_tick: period to the clock, no tick while disabled, every missed tick counted."""

import cocotb
import numpy as np

from playback import play
from runner import simulate

N_CLOCKS = 300


def inputs(cfg_clocks, *, enable=1, ready=1, reset=0) -> dict[str, np.ndarray]:
    columns = {"cfg_clocks": cfg_clocks, "cfg_enable": enable, "in_ready": ready, "rst": reset}
    return {name: np.broadcast_to(value, N_CLOCKS).copy() for name, value in columns.items()}


@cocotb.test()
@cocotb.parametrize(period=[0, 1, 2, 3, 7, 40])
async def ticks_to_the_clock(dut, period):
    enable = np.arange(N_CLOCKS) >= 10
    recorded = await play(dut, inputs(period, enable=enable), ["out_valid", "sts_missed"])
    np.testing.assert_array_equal(
        np.flatnonzero(recorded["out_valid"]), np.arange(10 + max(period, 1), N_CLOCKS, max(period, 1))
    )
    assert not recorded["sts_missed"].any()


@cocotb.test()
async def missed_ticks_are_counted(dut):
    rng = np.random.default_rng(21)
    cocotb.log.info("seed 21")
    ready = rng.random(N_CLOCKS) < 0.5
    reset = np.arange(N_CLOCKS) == 200
    recorded = await play(dut, inputs(3, ready=ready, reset=reset), ["out_valid", "sts_missed"])
    missed = (recorded["out_valid"] == 1) & ~ready
    before, after = missed[:200], missed[201:]
    assert before.sum() > 10
    np.testing.assert_array_equal(recorded["sts_missed"][1:201], before.cumsum())
    np.testing.assert_array_equal(recorded["sts_missed"][202:], after.cumsum()[:-1])


@cocotb.test()
@cocotb.parametrize(change=range(99, 122, 2))
async def new_period_counts_from_the_last_tick(dut, change):
    """From 20 clocks to 6, at different times after the tick that is seen at clock 100."""
    clocks = np.where(np.arange(N_CLOCKS) < change, 20, 6)
    ticks = np.flatnonzero((await play(dut, inputs(clocks), ["out_valid"]))["out_valid"])
    last = ticks[ticks <= change].max()
    first = ticks[ticks > change].min()
    assert last == (change // 20) * 20
    assert first == max(last + 6, change + 1)
    np.testing.assert_array_equal(np.diff(ticks[ticks >= first]), 6)


@cocotb.test()
async def period_that_comes_with_the_enable_counts(dut):
    late = np.arange(N_CLOCKS) >= 30
    recorded = await play(dut, inputs(np.where(late, 7, 4000), enable=late), ["out_valid"])
    assert np.flatnonzero(recorded["out_valid"])[0] == 37


@cocotb.test()
async def disabled_tick_is_silent(dut):
    enable = np.arange(N_CLOCKS) % 10 < 4  # never five clocks in a row
    recorded = await play(dut, inputs(5, enable=enable, ready=0), ["out_valid", "sts_missed"])
    assert not recorded["out_valid"].any()
    assert not recorded["sts_missed"].any()


def test_tick_keeps_its_period_and_counts_what_it_missed():
    simulate("gc_tick", "test_rtl_tick")
