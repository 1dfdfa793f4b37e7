"""Clock-accurate twin of gc_pwm: a signed value as pulses on two pins. gc_pwm.vhd has the equations."""

from math import floor, log2

import numpy as np

LATENCY = 4  # clocks from a value to the clock in which a period may begin with it


def clocks_on(value: int, clocks: int, full_scale: int) -> int:
    """Clocks of a period that are high for a value."""
    ratio = clocks / full_scale
    fraction = 16 - floor(log2(ratio))
    return min(clocks, abs(value) * round(ratio * 2.0**fraction) >> fraction)


def pwm(
    enable: np.ndarray, value: np.ndarray, *, clocks: int, full_scale: int, dead: int, two_pins: bool
) -> tuple[np.ndarray, np.ndarray]:
    """pin_a, pin_b (n,) before each rising edge, from enable and value (n,), from the clock after a reset on."""
    pins = np.zeros((2, len(value)), np.int64)
    high, wanted, wave, negative, quiet, rest = 0, 0, 0, 0, 0, dead
    for k in range(len(value)):
        pins[:, k] = (wave & ~negative, wave & negative) if two_pins else (wave, negative)
        position = k % clocks
        new_wave = int(position < high and enable[k] and not rest and wanted == negative)
        new_negative, new_rest = negative, max(0, rest - 1)
        if not rest and wanted != negative and not wave and quiet == dead:
            new_negative, new_rest = wanted, dead
        quiet = 0 if wave else min(dead, quiet + 1)
        if position == clocks - 1:
            taken = int(value[k - LATENCY + 1]) if k >= LATENCY - 1 else 0
            high = clocks_on(taken, clocks, full_scale)
            wanted = int(taken < 0) if high else wanted
        wave, negative, rest = new_wave, new_negative, new_rest
    return pins[0], pins[1]
