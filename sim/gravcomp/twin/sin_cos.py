"""Sine and cosine of a rotary axis from its count, as integers: gc_phase and gc_sin_cos, bit for bit.

A turn of the joint is a turn of the phase, so a joint that turns for ever wraps for free. Of the phase p = k + b, k the
nearest of 2^PLACE_BITS places of the turn, with b in rad:

    sin p = sin k + b cos k,  cos p = cos k - b sin k

Two reads of a quarter wave and two products per axis. What the first order leaves out is at most b^2 / 2.
"""

import numpy as np

from gravcomp.core.formats import COUNT_BITS, OPERAND_BITS, PHASE_BITS, SIN_COS_FRACTION, STEP_BITS

HALF_BITS = COUNT_BITS // 2
PLACE_BITS = 10
REST_BITS = PHASE_BITS - PLACE_BITS
RADIAN_FRACTION = 7  # 2 pi as a code: with the rest of the phase an operand of 18 bits
RADIAN = round(2 * np.pi * 2**RADIAN_FRACTION)
# Of the phase, in its LSB: its rounding, and either step's, half its LSB, times the most that it is multiplied by.
PHASE_ERROR_LSB = 0.5 + 2.0 ** (PHASE_BITS - STEP_BITS - 1) * (2.0 ** (HALF_BITS - 1) + 2.0**HALF_BITS)
_LARGEST = 2 ** (OPERAND_BITS - 1) - 1
_REST_RAD = np.pi / 2**PLACE_BITS  # largest b
# In LSB of the result: table, rounded product, 2 pi as a code, first order, and 1 - LSB in place of 1.
ERROR_LSB = (
    0.5
    + 0.5
    + 2.0**SIN_COS_FRACTION * _REST_RAD * (abs(RADIAN / 2**RADIAN_FRACTION / (2 * np.pi) - 1) + _REST_RAD / 2)
    + 1.0
)


def phase(count: np.ndarray, coarse_step: np.ndarray, fine_step: np.ndarray) -> np.ndarray:
    """gc_phase: phase codes (...), modulo 2^PHASE_BITS, within PHASE_ERROR_LSB of count / counts_per_turn turns.

    count (...): 32-bit counts. coarse_step, fine_step: turns per 2^HALF_BITS counts and per count, STEP_BITS fraction
    bits.
    """
    count, drop = np.asarray(count, dtype=np.int64), STEP_BITS - PHASE_BITS
    turned = (count >> HALF_BITS) * coarse_step + (count & 2**HALF_BITS - 1) * fine_step + (1 << drop - 1)
    return (turned >> drop) & (2**PHASE_BITS - 1)


def sin_cos(phase_code: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """gc_sin_cos: codes of sine and cosine with SIN_COS_FRACTION bits at phase codes, within ERROR_LSB of them."""
    place = (phase_code + 2 ** (REST_BITS - 1)) >> REST_BITS
    angle = (phase_code - (place << REST_BITS)) * RADIAN
    sine, cosine = _TABLE[place % 2**PLACE_BITS], _TABLE[(place + 2 ** (PLACE_BITS - 2)) % 2**PLACE_BITS]
    drop = PHASE_BITS + RADIAN_FRACTION
    half = 1 << drop - 1
    both = sine + (cosine * angle + half >> drop), cosine + (-sine * angle + half >> drop)
    return tuple(np.clip(value, -_LARGEST - 1, _LARGEST) for value in both)


_TABLE = np.rint(2.0**SIN_COS_FRACTION * np.sin(2 * np.pi * np.arange(2**PLACE_BITS) / 2**PLACE_BITS))
_TABLE = np.clip(_TABLE, -_LARGEST, _LARGEST).astype(np.int64)
