"""gc_pwm equals its twin at every clock; its pins keep what its header promises, whatever the values."""

import os

import cocotb
import numpy as np
import pytest

from codes import corners_and_random
from gravcomp.twin.pwm import LATENCY, clocks_on, pwm
from playback import assert_equal, play
from runner import simulate

GENERICS = {"clocks_g": 40, "full_scale_g": 1000, "dead_g": 5}


def settings() -> dict:
    names = {"clocks_g": "clocks", "full_scale_g": "full_scale", "dead_g": "dead"}
    return {name: int(os.environ[generic.upper()]) for generic, name in names.items()}


def n_periods() -> int:
    return 60 if settings()["clocks"] < 100 else 6


def is_two_pins() -> bool:
    return os.environ["TWO_PINS_G"] in ("true", "True", "1")


async def run_and_compare(dut, value, enable) -> tuple[np.ndarray, np.ndarray]:
    inputs = {"rst": np.zeros_like(value), "enable": enable, "in_value": value}
    got = await play(dut, inputs, ["pin_a", "pin_b"])
    expected = pwm(enable, value, **settings(), two_pins=is_two_pins())
    assert_equal(got, dict(zip(("pin_a", "pin_b"), expected, strict=True)))
    return got["pin_a"], got["pin_b"]


@cocotb.test()
@cocotb.parametrize(seed=[1])
async def equals_twin(dut, seed):
    """Values of all sizes and both signs that change at any clock, with stops."""
    cocotb.log.info("seed %d", seed)
    rng, known = np.random.default_rng(seed), settings()
    n_clocks = n_periods() * known["clocks"]
    value = corners_and_random(32, (n_clocks,), rng) >> rng.integers(0, 31, n_clocks)
    value = value[np.arange(n_clocks) // int(rng.integers(1, 2 * known["clocks"])) % n_clocks]
    enable = (rng.random(n_clocks) > 0.01).astype(np.int64)
    await run_and_compare(dut, value, enable)


@cocotb.test()
async def pulses_are_as_long_as_the_value(dut):
    known = settings()
    values = [0, 1, 24, 25, 26, 500, 999, 1000, 1001, 2**31 - 1]
    value = np.repeat(np.array([0, *values, 0]), 3 * known["clocks"])
    pin_a, pin_b = await run_and_compare(dut, value, np.ones_like(value))
    assert not pin_b.any()
    for k, expected in enumerate(values, start=1):
        start = (3 * k + 1) * known["clocks"] + 1  # the second period of three, a register later
        n_high = pin_a[start : start + known["clocks"]].sum()
        assert n_high == clocks_on(expected, known["clocks"], known["full_scale"])
        assert abs(n_high - min(expected, known["full_scale"]) * known["clocks"] / known["full_scale"]) <= 1


@cocotb.test()
async def no_pin_is_high_around_a_change_of_the_sign(dut):
    """At any place of a period, and for signs that change sooner than the pins can."""
    known, rng = settings(), np.random.default_rng(4)
    n_clocks = n_periods() * known["clocks"]
    flips = np.cumsum(rng.integers(1, 3 * known["clocks"], n_clocks))
    sign = (-1) ** np.searchsorted(flips, np.arange(n_clocks))
    value = sign * rng.integers(600, 1200, n_clocks)
    pin_a, pin_b = await run_and_compare(dut, value, np.ones_like(value))
    if is_two_pins():
        assert not (pin_a & pin_b).any()
        signs, quiet = np.where(pin_b, -1, pin_a), 2 * known["dead"]
        high = np.flatnonzero(signs)
        gaps = np.diff(high)[signs[high[1:]] != signs[high[:-1]]] - 1
    else:
        changes = np.flatnonzero(np.diff(pin_b)) + 1
        quiet = known["dead"]
        gaps = [n for k in changes for n in (np.argmax(pin_a[k - 1 :: -1]), np.argmax(pin_a[k:])) if k + n < n_clocks]
    assert len(gaps) > 5
    assert min(gaps) >= quiet


@cocotb.test()
async def stop_is_low_one_clock_later(dut):
    known = settings()
    value = np.full(4 * known["clocks"], 700)
    for stop in range(known["clocks"] + LATENCY, 2 * known["clocks"] + 6, 3):
        enable = np.ones_like(value)
        enable[stop : stop + 4] = 0
        pin_a, _ = await run_and_compare(dut, value, enable)
        assert not pin_a[stop + 1 : stop + 5].any()


@pytest.mark.parametrize("two_pins", ["true", "false"])
@pytest.mark.parametrize("dead", [0, 5])
def test_pwm_equals_twin(two_pins, dead):
    simulate("gc_pwm", "test_rtl_pwm", generics={**GENERICS, "dead_g": dead, "two_pins_g": two_pins})


def test_pwm_of_a_real_period_equals_twin():
    """20 kHz of 40 MHz, 10 A: the defaults."""
    generics = {"clocks_g": 2000, "full_scale_g": 10_000_000, "dead_g": 20, "two_pins_g": "false"}
    simulate("gc_pwm", "test_rtl_pwm", generics=generics, tests="equals_twin")


@pytest.mark.parametrize("clocks", [1, 65536])
def test_pwm_refuses_clocks(clocks):
    with pytest.raises(AssertionError, match=f"gc_pwm: need clocks_g in 2 to 65535, got {clocks}"):
        simulate("gc_pwm", "test_rtl_pwm", generics={"clocks_g": clocks})


def test_clocks_are_exact_to_one_for_any_scale():
    rng = np.random.default_rng(5)
    for _ in range(2000):
        clocks, full_scale = int(rng.integers(2, 65536)), int(rng.integers(2, 2 ** rng.integers(2, 32)))
        value = int(rng.integers(0, full_scale, endpoint=True))
        exact = value * clocks / full_scale
        assert abs(clocks_on(value, clocks, full_scale) - exact) <= 1 + exact * 2**-17
        assert clocks_on(-(2**31), clocks, full_scale) == clocks_on(2**31 - 1, clocks, full_scale)
