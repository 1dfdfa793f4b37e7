"""gc_setpoint equals its twin tick by tick: together, on time or later for the limits, exactly to the target."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import corners_and_random, pack, unpack
from gravcomp.twin.setpoint import (
    ACCELERATION_FRACTION,
    PHASE_BITS,
    SPEED_FRACTION,
    blend,
    keeps_limits,
    path,
    rate_of,
    ticks_of,
)
from gravcomp_lab.benches.stream import start
from runner import simulate

FREE = 2**32 - 1
LIMIT_NAMES = ("speed", "acceleration")


def n_axes() -> int:
    return int(os.environ["AXES_G"])


def tick_clocks() -> int:
    """Clocks from in_valid to the last setpoint."""
    return 10 + 3 * n_axes()


def setpoints(dut) -> list[int]:
    return unpack([int(dut.out_setpoint.value)], 32, n_axes())[0].tolist()


async def begin(dut, count) -> None:
    dut.in_valid.value = dut.move_valid.value = dut.run.value = 0
    dut.in_count.value = pack(count, 32)
    await start(dut)
    await FallingEdge(dut.clk)
    assert setpoints(dut) == list(count)
    dut.run.value = 1
    await FallingEdge(dut.clk)


async def move(dut, target, ticks, speed, acceleration) -> None:
    """Hand over a move and wait until it is planned: at rest again, or waiting for its first tick."""
    dut.cfg_speed.value, dut.cfg_acceleration.value = pack(speed, 32), pack(acceleration, 32)
    dut.move_target.value, dut.move_ticks.value, dut.move_valid.value = pack(target, 32), ticks, 1
    assert dut.move_ready.value == 1
    await FallingEdge(dut.clk)
    dut.move_valid.value = dut.move_target.value = dut.move_ticks.value = 0
    spans = [t - s for s, t in zip(setpoints(dut), target, strict=True)]
    trials, rate = 1, (1 << PHASE_BITS) // max(ticks, 2)
    while rate and not keeps_limits(rate, spans, speed, acceleration):
        rate, trials = rate - max(1, rate >> 4), trials + 1
    for _ in range(33 + 6 * n_axes() * trials):
        await FallingEdge(dut.clk)


async def tick(dut) -> list[int]:
    dut.in_valid.value = 1
    await FallingEdge(dut.clk)
    dut.in_valid.value = 0
    for _ in range(tick_clocks() - 1):
        await FallingEdge(dut.clk)
    return setpoints(dut)


@cocotb.test()
@cocotb.parametrize(ticks=[0, 2, 3, 10, 61])
async def equals_twin(dut, ticks):
    rng, n = np.random.default_rng(ticks), n_axes()
    begin_at, target = ([int(x) for x in corners_and_random(32, (n,), rng)] for _ in range(2))
    await begin(dut, begin_at)
    await move(dut, target, ticks, [FREE] * n, [FREE] * n)
    rate = int(dut.sts_rate.value)
    assert rate == rate_of(ticks, [t - b for b, t in zip(begin_at, target, strict=True)], [FREE] * n, [FREE] * n)
    for expected in path(begin_at, target, rate)[:70]:
        assert dut.move_ready.value == 0
        assert await tick(dut) == expected
    if ticks_of(rate) <= 70:
        assert (dut.move_ready.value, setpoints(dut)) == (1, target)
        assert await tick(dut) == target


@cocotb.test()
@cocotb.parametrize(seed=[3, 4])
async def limits_lengthen_the_move_of_all_axes(dut, seed):
    """Moves from target to target; peaks of the differences keep the limits but for the rounding to counts."""
    cocotb.log.info("seed %d", seed)
    rng, n = np.random.default_rng(seed), n_axes()
    at = [int(x) for x in rng.integers(-1000, 1000, n)]
    await begin(dut, at)
    for _ in range(2):
        target = [int(x) for x in rng.integers(-20_000, 20_000, n)]
        speed = [int(x) for x in rng.integers(200, 900, n) << SPEED_FRACTION]
        acceleration = [int(x) for x in rng.integers(5, 40, n) << ACCELERATION_FRACTION]
        await move(dut, target, 20, speed, acceleration)
        rate = int(dut.sts_rate.value)
        assert rate == rate_of(20, [t - a for a, t in zip(at, target, strict=True)], speed, acceleration)
        rows = [at, *[await tick(dut) for _ in range(ticks_of(rate))]]
        assert rows[1:] == path(at, target, rate)
        steps = np.diff(rows, axis=0, prepend=[at], append=[target])
        assert (np.abs(steps).max(axis=0) <= np.array(speed) / 2**SPEED_FRACTION + 1).all()
        bend = np.abs(np.diff(steps, axis=0)).max(axis=0)
        assert (bend <= np.array(acceleration) / 2**ACCELERATION_FRACTION + 2).all()
        at = target


@cocotb.test()
async def move_that_cannot_keep_its_limits_is_refused(dut):
    """A limit of zero on the last axis stops all; an axis that stays needs no limit."""
    n, at = n_axes(), [5] * n_axes()
    await begin(dut, at)
    for name in LIMIT_NAMES:
        limits = {"speed": [FREE] * n, "acceleration": [FREE] * n}
        limits[name] = [*limits[name][:-1], 0]
        await move(dut, [99] * n, 50, **limits)
        assert (dut.move_ready.value, dut.sts_refused.value) == (1, 1)
        assert await tick(dut) == at
    await move(dut, [*[99] * (n - 1), 5], 2, [*[FREE] * (n - 1), 0], [*[FREE] * (n - 1), 0])
    assert dut.sts_refused.value == 0


@cocotb.test()
async def stop_drops_the_move_at_every_clock_of_it(dut):
    """Whatever it is at: the setpoint is the count one clock later, and no tick moves it."""
    n = n_axes()
    for clocks in range(0, 60 + 6 * n + 3 * tick_clocks(), 7):
        await begin(dut, [0] * n)
        dut.cfg_speed.value = dut.cfg_acceleration.value = pack([FREE] * n, 32)
        dut.move_target.value, dut.move_ticks.value, dut.move_valid.value = pack([1000] * n, 32), 40, 1
        for k in range(clocks):
            dut.in_valid.value = int(k % tick_clocks() == 0)
            await FallingEdge(dut.clk)
            dut.move_valid.value = 0
        dut.in_valid.value = dut.move_valid.value = dut.run.value = 0
        dut.in_count.value = pack([77] * n, 32)
        await FallingEdge(dut.clk)
        assert (setpoints(dut), dut.move_ready.value) == ([77] * n, 0)
        dut.run.value = 1
        assert await tick(dut) == [77] * n
        assert dut.move_ready.value == 1


@cocotb.test()
async def target_that_comes_on_the_way_is_not_taken(dut):
    n = n_axes()
    await begin(dut, [0] * n)
    await move(dut, [600] * n, 8, [FREE] * n, [FREE] * n)
    dut.move_target.value, dut.move_valid.value = pack([-600] * n, 32), 1
    rows = [await tick(dut) for _ in range(7)]
    dut.move_valid.value = 0
    assert [*rows, await tick(dut)] == path([0] * n, [600] * n, rate_of(8, [600] * n, [FREE] * n, [FREE] * n))


@cocotb.test()
async def tick_that_comes_too_soon_is_not_taken(dut):
    n = n_axes()
    await begin(dut, [0] * n)
    await move(dut, [600] * n, 8, [FREE] * n, [FREE] * n)
    expected = path([0] * n, [600] * n, rate_of(8, [600] * n, [FREE] * n, [FREE] * n))
    dut.in_valid.value = 1
    for _ in range(tick_clocks()):
        await FallingEdge(dut.clk)
    dut.in_valid.value = 0
    assert setpoints(dut) == expected[0]
    assert await tick(dut) == expected[1]


@cocotb.test()
async def reset_in_mid_move(dut):
    n = n_axes()
    await begin(dut, [3] * n)
    await move(dut, [600] * n, 8, [FREE] * n, [FREE] * n)
    await tick(dut)
    dut.rst.value = 1
    await FallingEdge(dut.clk)
    dut.rst.value = 0
    assert (setpoints(dut), dut.move_ready.value) == ([3] * n, 1)
    assert await tick(dut) == [3] * n


@pytest.mark.parametrize("axes", [1, 3, 8])
def test_setpoint_equals_twin(axes):
    tests = None if axes < 8 else "equals_twin"
    simulate("gc_setpoint", "test_rtl_setpoint", generics={"axes_g": axes}, tests=tests)


def test_setpoint_refuses_axes():
    with pytest.raises(AssertionError, match="gc_setpoint: need axes_g <= 8, got 9"):
        simulate("gc_setpoint", "test_rtl_setpoint", generics={"axes_g": 9})


def test_blend_is_minimum_jerk_and_never_above_it():
    """Rounded down at four places: 2**-32 each, and 2**-28 of the factor, on s at most 10 times as large."""
    rng = np.random.default_rng(2)
    for phase in [0, 1, 2**31, 2**32 - 1, *rng.integers(0, 2**32, 5000).tolist()]:
        u = phase / 2**32
        exact = u**3 * (10 - 15 * u + 6 * u * u)
        assert -2e-9 * 4 <= blend(phase) / 2**32 - exact <= 1e-15
        assert 0 <= blend(phase) < 2**32


def test_factor_stays_within_its_width():
    """10 - 15 u + 6 u**2 falls from 10 to 1; 32 bits with 28 behind the point hold 16."""
    for phase in np.linspace(0, 2**32 - 1, 10_001).astype(np.int64).tolist():
        factor = (10 << 32) - 15 * phase + 6 * (phase * phase >> 32)
        assert (1 << 32) - 6 <= factor <= 10 << 32


@pytest.mark.parametrize("seed", [1, 2])
def test_speed_and_acceleration_of_paths_keep_any_limits(seed):
    """Over drawn moves: the difference of setpoints keeps the limits but for the rounding to counts; nothing is much
    slower than it must be: one step of u longer breaks a limit, or the time asked for is met."""
    rng = np.random.default_rng(seed)
    for _ in range(60):
        span, ticks = int(rng.integers(1, 2 ** rng.integers(4, 31))), int(rng.integers(2, 400))
        speed = [int(span * 2**SPEED_FRACTION / rng.uniform(20, 800))]
        acceleration = [int(span * 2**ACCELERATION_FRACTION / rng.uniform(20, 800) ** 2)]
        rate = rate_of(ticks, [span], speed, acceleration)
        if not rate:
            assert not min(*speed, *acceleration) or span < 800**2
            continue
        rows = np.array(path([0], [span], rate))[:, 0]
        steps = np.diff(rows, prepend=[0, 0], append=[span, span])
        assert np.abs(steps).max() <= speed[0] / 2**SPEED_FRACTION + 1
        assert np.abs(np.diff(steps)).max() <= acceleration[0] / 2**ACCELERATION_FRACTION + 2
        is_on_time = rate == 2**32 // ticks
        assert is_on_time or not keeps_limits(rate + max(2, rate // 14), [span], speed, acceleration)
        assert len(rows) >= ticks
