"""gc_servo equals its twin at every tick, corners included; no sum can overflow; release is without a jump."""

import os
import re
from dataclasses import replace

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import corners_and_random, pack, unpack
from gravcomp.twin.servo import (
    CURRENT_BITS,
    DISTANCE_BITS,
    GAIN_BITS,
    INTEGRAL_FRACTION,
    SLOW_FRACTION,
    STEPS,
    Gains,
    ServoAxis,
    clip,
    gains_of,
    intervals,
    saturate,
    servo,
)
from gravcomp_lab.benches.stream import start
from runner import ROOT, simulate

WIDTHS = {"proportional": GAIN_BITS, "integral": GAIN_BITS, "derivative": GAIN_BITS, "limit": 31, "astray": 32}
TYPICAL = Gains(proportional=300 << 12, integral=2 << 18, derivative=4000, filter=3, limit=2_000_000, astray=500)


def n_axes() -> int:
    return int(os.environ["AXES_G"])


def configure(dut, gains) -> None:
    """Gains of all axes; they share a filter and what its derivative is of."""
    for name, bits in WIDTHS.items():
        getattr(dut, f"cfg_{name}").value = pack([getattr(g, name) for g in gains], bits)
    dut.cfg_filter.value, dut.cfg_speed_feed.value = gains[0].filter, int(gains[0].speed_feed)


async def begin(dut, gains, run=1) -> None:
    dut.feed_valid.value = 0
    dut.run.value = 0
    configure(dut, gains)
    await start(dut)
    await FallingEdge(dut.clk)
    dut.run.value = run


async def tick(dut, count, setpoint) -> tuple[list[int], list[int]]:
    """Corrections and flags after a tick, at the clock in which the header promises them."""
    dut.in_count.value, dut.in_setpoint.value = pack(count, 32), pack(setpoint, 32)
    dut.in_valid.value = 1
    await FallingEdge(dut.clk)
    dut.in_valid.value = 0
    dut.in_count.value, dut.in_setpoint.value = pack(~np.asarray(count), 32), 0  # nothing looks at them any more
    for _ in range(STEPS * n_axes()):
        await FallingEdge(dut.clk)
    return unpack_all(dut)


def unpack_all(dut) -> tuple[list[int], list[int]]:
    corrections = unpack([int(dut.sts_correction.value)], 32, n_axes())[0]
    return corrections.tolist(), [int(dut.out_astray.value) >> k & 1 for k in range(n_axes())]


@cocotb.test()
@cocotb.parametrize(seed=[1, 2])
async def equals_twin_for_any_gain_and_count(dut, seed):
    """Corners and random values of all inputs, gains and limits that change between ticks, stops in between."""
    cocotb.log.info("seed %d", seed)
    rng, n = np.random.default_rng(seed), n_axes()
    await begin(dut, [Gains()] * n)
    axes, feeds = [ServoAxis() for _ in range(n)], False
    for _ in range(100):
        feeds ^= bool(rng.random() < 0.2)
        shift = int(rng.integers(0, 31))
        count, setpoint = (corners_and_random(32, (n,), rng) >> shift for _ in range(2))
        drawn = {
            name: [abs(int(x)) >> int(rng.integers(0, bits)) for x in corners_and_random(bits + 1, (n,), rng)]
            for name, bits in WIDTHS.items()
        }
        drawn = {name: [min(x, 2 ** WIDTHS[name] - 1) for x in values] for name, values in drawn.items()}
        filter_ = int(rng.integers(0, 16))
        shared = {"filter": filter_, "speed_feed": feeds}
        gains = [Gains(**shared, **{name: values[k] for name, values in drawn.items()}) for k in range(n)]
        configure(dut, gains)
        if rng.random() < 0.1:
            dut.run.value = 0
            await FallingEdge(dut.clk)
            dut.run.value = 1
            for axis in axes:
                axis.stop()
        got, astray = await tick(dut, count, setpoint)
        expected = [a.tick(int(c), int(s), g) for a, c, s, g in zip(axes, count, setpoint, gains, strict=True)]
        assert got == expected
        assert astray == [a.is_astray for a in axes]


@cocotb.test()
@cocotb.parametrize(speed_feed=[False, True])
async def largest_inputs_do_not_overflow(dut, speed_feed):
    """The largest of every gain, at the largest errors and lags in both directions, until the integral is full."""
    n = n_axes()
    gains = [Gains(2**32 - 1, 2**32 - 1, 2**32 - 1, 0, 2**31 - 1, speed_feed=speed_feed)] * n
    low, high = -(2**31), 2**31 - 1
    counts = [[c] * n for c in (low, low, high, high, low, high, 0, low, high)]
    setpoints = [[s] * n for s in (high, high, low, high, high, low, low, low, low)]
    await begin(dut, gains)
    for count, setpoint, expected in zip(counts, setpoints, servo(counts, setpoints, gains), strict=True):
        assert (await tick(dut, count, setpoint))[0] == expected


@cocotb.test()
async def zero_gains_are_transparent(dut):
    rng, n = np.random.default_rng(8), n_axes()
    await begin(dut, [TYPICAL] * n)
    await tick(dut, [0] * n, [400] * n)
    configure(dut, [Gains()] * n)
    for _ in range(5):
        assert (await tick(dut, rng.integers(-(2**31), 2**31, n), [0] * n))[0] == [0] * n
        feed = corners_and_random(CURRENT_BITS, (n,), rng)
        dut.feed_current.value, dut.feed_valid.value = pack(feed, 32), 1
        await FallingEdge(dut.clk)
        dut.feed_valid.value = 0
        assert dut.out_valid.value == 1
        assert unpack([int(dut.out_current.value)], 32, n)[0].tolist() == feed.tolist()
        await FallingEdge(dut.clk)
        assert dut.out_valid.value == 0


@cocotb.test()
async def feed_and_correction_saturate(dut):
    n = n_axes()
    await begin(dut, [Gains(proportional=2**32 - 1)] * n)
    for error in (2**22, -(2**22)):
        correction, _ = await tick(dut, [0] * n, [error] * n)
        for feed in (2**31 - 1, -(2**31), 5):
            dut.feed_current.value, dut.feed_valid.value = pack([feed] * n, 32), 1
            await FallingEdge(dut.clk)
            dut.feed_valid.value = 0
            got = unpack([int(dut.out_current.value)], 32, n)[0].tolist()
            assert got == [saturate(feed + c, 32) for c in correction]


@cocotb.test()
@cocotb.parametrize(speed_feed=[False, True])
async def release_is_without_a_jump(dut, speed_feed):
    """After a stop nothing of before is left: no correction at the setpoint, whatever the speed and integral were."""
    n = n_axes()
    await begin(dut, [replace(TYPICAL, speed_feed=speed_feed)] * n)
    for k in range(20):
        await tick(dut, [50 * k] * n, [0] * n)
    assert all((await tick(dut, [2000] * n, [0] * n))[0])
    dut.run.value = 0
    await FallingEdge(dut.clk)
    assert unpack_all(dut) == ([0] * n, [0] * n)
    dut.run.value = 1
    assert await tick(dut, [2100] * n, [2100] * n) == ([0] * n, [0] * n)
    assert await tick(dut, [2100] * n, [2100] * n) == ([0] * n, [0] * n)


@cocotb.test()
@cocotb.parametrize(speed_feed=[False, True])
async def speed_feed_changes_without_a_jump(dut, speed_feed):
    """Held far from the zero of its counts: from the tick on that finds the other setting nothing is asked."""
    n, here = n_axes(), [3_000_000] * n_axes()
    damped = Gains(derivative=4000, filter=3)
    await begin(dut, [replace(damped, speed_feed=speed_feed)] * n)
    for k in range(4):
        configure(dut, [replace(damped, speed_feed=speed_feed ^ (k >= 2))] * n)
        assert (await tick(dut, here, here))[0] == [0] * n


@cocotb.test()
async def fault_in_the_middle_of_a_tick_leaves_nothing(dut):
    n = n_axes()
    for clocks in range(1, STEPS * n + 1):
        await begin(dut, [TYPICAL] * n)
        await tick(dut, [0] * n, [100] * n)
        dut.in_count.value, dut.in_setpoint.value, dut.in_valid.value = 0, pack([200] * n, 32), 1
        for _ in range(clocks):
            await FallingEdge(dut.clk)
            dut.in_valid.value = 0
        dut.run.value = 0
        for _ in range(STEPS * n + 2):
            await FallingEdge(dut.clk)
            assert unpack_all(dut) == ([0] * n, [0] * n)


@cocotb.test()
async def tick_that_comes_too_soon_is_dropped(dut):
    n = n_axes()
    await begin(dut, [Gains(proportional=1 << 12)] * n)
    dut.in_count.value, dut.in_setpoint.value, dut.in_valid.value = 0, pack([7] * n, 32), 1
    await FallingEdge(dut.clk)
    dut.in_setpoint.value = pack([9] * n, 32)
    for _ in range(STEPS * n - 1):
        await FallingEdge(dut.clk)
    dut.in_valid.value = 0
    for _ in range(3):
        await FallingEdge(dut.clk)
    assert unpack_all(dut)[0] == [7] * n


@cocotb.test()
async def reset_in_mid_tick_forgets(dut):
    n = n_axes()
    await begin(dut, [TYPICAL] * n)
    await tick(dut, [0] * n, [900] * n)
    dut.in_valid.value = 1
    await FallingEdge(dut.clk)
    dut.in_valid.value = 0
    dut.rst.value = 1
    await FallingEdge(dut.clk)
    dut.rst.value = 0
    for _ in range(STEPS * n + 2):
        assert unpack_all(dut) == ([0] * n, [0] * n)
        await FallingEdge(dut.clk)


@pytest.mark.parametrize("axes", [1, 3, 8])
def test_servo_equals_twin(axes):
    tests = None if axes < 8 else "equals_twin"
    simulate("gc_servo", "test_rtl_servo", generics={"axes_g": axes}, tests=tests)


def test_servo_refuses_axes():
    with pytest.raises(AssertionError, match="gc_servo: need axes_g <= 8, got 9"):
        simulate("gc_servo", "test_rtl_servo", generics={"axes_g": 9})


def signal_bits(name: str) -> int:
    """Width of a signal of gc_servo, from its declaration and the constants that it is made of."""
    text = (ROOT / "rtl/motion/gc_servo_pkg.vhd").read_text() + (ROOT / "rtl/motion/gc_servo.vhd").read_text()
    constants = dict(re.findall(r"constant (\w+) *: (?:positive|natural) := (.+);", text))

    def value(expression: str) -> int:
        while found := re.search(r"\b[a-z]\w*_c\b", expression):
            expression = expression.replace(found[0], f"({constants[found[0]]})")
        return eval(expression, {"__builtins__": {}})

    (high,) = re.findall(rf"signal {name} +: signed\((.+) downto 0\)", text) or re.findall(
        rf"type {name}s_t is array \(.*\) of signed\((.+) downto 0\)", text
    )
    return value(high) + 1


@pytest.mark.parametrize(("name", "interval"), intervals().items())
def test_no_sum_overflows_for_any_input(name, interval):
    """By intervals over every gain, count, setpoint and integral; the widths are those that the VHDL declares."""
    low, high = interval
    half = 2 ** (signal_bits(name) - 1)
    assert -half <= low <= high < half
    assert high >= half // 4 or name == "total_8"  # nor is it much wider than it must be


def test_sums_of_extremes_reach_their_intervals():
    """The intervals are those of what happens: extremes come near them and stay within."""
    axis, gains, most = ServoAxis(), Gains(2**32 - 1, 2**32 - 1, 2**32 - 1, 0, 2**31 - 1, speed_feed=True), {}
    for k in range(40):
        axis.tick((-1) ** k * (2**31 - 1), (-1) ** (k + k // 3) * (2**31 - 1), gains)
        for name, value in axis.sums.items():
            assert intervals()[name][0] <= value <= intervals()[name][1], name
            most[name] = max(most.get(name, 0), abs(value))
    assert all(most[name] > 0.9 * high for name, (_, high) in intervals().items()), most


def test_low_pass_comes_to_rest_without_a_lag():
    """For every filter: after a step and a long rest the derivative sees nothing."""
    for filter_ in range(16):
        axis, gains = ServoAxis(), Gains(derivative=1 << 8, filter=filter_)
        axis.tick(0, 0, gains)
        for _ in range(25 << filter_):
            correction = axis.tick(12345, 0, gains)
        assert correction == 0, filter_
        assert abs((12345 << SLOW_FRACTION) - axis.slow) < 2**filter_


def test_integral_neither_winds_up_nor_leaves_its_limit():
    """A long saturation is left as soon as the error changes its sign enough to unload P; bound by arithmetic."""
    gains = Gains(proportional=100 << 12, integral=1 << 20, limit=10_000)
    axis = ServoAxis()
    for _ in range(1000):
        axis.tick(0, 1000, gains)  # P alone is ten times the limit
    assert axis.correction == 10_000
    assert abs(axis.summed) <= 10_000 << INTEGRAL_FRACTION
    assert axis.summed == 0  # it never helped, so it was never loaded
    assert axis.tick(0, 0, gains) == 0
    for _ in range(1000):
        axis.tick(0, 50, gains)  # P is half the limit: the integral takes the rest
    assert axis.correction == 10_000
    assert 0 < axis.summed >> INTEGRAL_FRACTION <= 5_000


def test_gains_in_units_of_the_user():
    """P is uA per count; I per second and D per speed lose the tick. Steady speed: lag is 2**filter ticks of it."""
    gains = gains_of(250.0, 1000.0, 20.0, tick_s=1e-3, filter_=4, limit_ua=10**9)
    assert ServoAxis().tick(0, 10, gains_of(250.0, 0, 0, 1e-3, 4, 10**9)) == 2500
    axis = ServoAxis()
    for _ in range(1001):
        held = axis.tick(0, 10, gains)
    assert abs(held - (2500 + 1000 * 10 * 1.0)) <= 15
    axis, moving = ServoAxis(), gains_of(0, 0, 20.0, 1e-3, 4, 10**9)
    for k in range(2000):
        drag = axis.tick(3 * k, 0, moving)  # 3000 counts/s
    assert abs(drag + 20.0 * 3000) <= 20.0 * 1000 / 2**4
    with pytest.raises(ValueError, match=r"derivative gain: \d+ is not within 0 and 4294967295"):
        gains_of(1, 1, 1e9, 1e-3, 0, 1)


def test_speed_feed_takes_the_drag_of_a_wanted_motion():
    """At the setpoint's own speed D asks for nothing, ahead of it for as much as the difference; by the formula."""
    speed, tick_s, filter_, damping_ua = 3, 1e-3, 4, 20.0
    gains = gains_of(0, 0, damping_ua, tick_s, filter_, 10**9, speed_feed=True)
    follows, overtakes = ServoAxis(), ServoAxis()
    for k in range(2000):
        assert follows.tick(speed * k - 500, speed * k, gains) == 0
        drag = overtakes.tick((speed + 1) * k, speed * k, gains)
    assert abs(drag + damping_ua * 1 / tick_s) <= damping_ua / tick_s / 2**filter_


def test_servo_holds_a_mass_against_a_load_of_unknown_weight():
    """A mass of 20 kg on a linear motor of 45 N/A, 1 um counts, a load of 60 N that no feed-forward knows, at 1 kHz."""
    tick_s, mass_kg, n_per_a, load_n, metre = 1e-3, 20.0, 45.0, 60.0, 1e-6
    omega = 2 * np.pi * 15
    ua = mass_kg * metre / n_per_a * 1e6
    gains = gains_of(3 * omega**2 * ua, omega**3 * ua, 3 * omega * ua, tick_s, 2, 20e6)
    axis, x, v, errors = ServoAxis(), 0.0, 0.0, []
    for _ in range(2000):
        force_n = axis.tick(int(np.floor(x / metre)), 0, gains) * 1e-6 * n_per_a - load_n
        for _ in range(10):
            v += force_n / mass_kg * tick_s / 10
            x += v * tick_s / 10
        errors.append(x / metre)
    assert max(np.abs(errors)) > 50  # it fell at first
    assert np.abs(errors[-500:]).max() <= 3
    assert abs(axis.correction * 1e-6 * n_per_a - load_n) < 0.05 * load_n


def test_clips():
    assert [clip(x, 5) for x in (-9, -5, 0, 5, 9)] == [-5, -5, 0, 5, 5]
    assert [saturate(x, DISTANCE_BITS) for x in (2**23, -(2**23) - 1)] == [2**23 - 1, -(2**23)]
