"""Bit-true model of gc_compensator: forces with friction and cogging from the tables of ``core.compensator_tables``."""

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.compensator_tables import (
    FRACTION_BITS,
    MANTISSA_BITS,
    MU_FRACTION,
    N_SPEEDS,
    PERIOD_BITS,
    PHASE_BITS,
    FixedCompensation,
)
from gravcomp.facts import POSITION_ADDRESS_BITS
from gravcomp.robot.machine import Drive
from gravcomp.twin.network import saturate


def speed_code(period: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """gc_speed_code: signed periods to addresses of the speed tables and places between two nodes, FRACTION_BITS."""
    magnitude = np.abs(np.asarray(period, dtype=np.int64))
    exponent = np.zeros_like(magnitude)
    for bit in range(1, PERIOD_BITS):
        exponent = np.where(magnitude >> bit > 0, bit, exponent)
    mantissa = (magnitude << (PERIOD_BITS - 1 - exponent)) & (2 ** (PERIOD_BITS - 1) - 1)
    eighth = mantissa >> (PERIOD_BITS - 1 - MANTISSA_BITS)
    fraction = (mantissa >> (PERIOD_BITS - 1 - MANTISSA_BITS - FRACTION_BITS)) & (2**FRACTION_BITS - 1)
    return np.where(np.asarray(period) < 0, N_SPEEDS, 0) + (exponent << MANTISSA_BITS) + eighth, fraction


def table(address: np.ndarray, fraction: np.ndarray, words: np.ndarray) -> np.ndarray:
    """gc_table: value + step * fraction, rounded; address and fraction (..., n), words (n, k, 2)."""
    axis = np.arange(len(words))
    value, step = words[axis, address, 0], words[axis, address, 1]
    return (value << FRACTION_BITS) + step * fraction + 2 ** (FRACTION_BITS - 1) >> FRACTION_BITS


def friction(force_mn: np.ndarray, period: np.ndarray, fixed: FixedCompensation) -> np.ndarray:
    """gc_friction: mN (..., n), from forces in mN and signed periods (..., n)."""
    address, fraction = speed_code(period)
    sliding = table(address, fraction, fixed.friction)
    load = table(address, fraction, fixed.mu) * np.abs(force_mn)
    return (sliding << MU_FRACTION) + load + 2 ** (MU_FRACTION - 1) >> MU_FRACTION


def position_table(count: np.ndarray, fixed: FixedCompensation) -> np.ndarray:
    """gc_position_table: mN (..., n), from encoder counts (..., n)."""
    phase = np.asarray(count, dtype=np.int64) * fixed.phase_step & (2**PHASE_BITS - 1)
    place = phase >> (PHASE_BITS - POSITION_ADDRESS_BITS - FRACTION_BITS)
    return table(place >> FRACTION_BITS, place & (2**FRACTION_BITS - 1), fixed.position)


def compensator(
    force_mn: np.ndarray, count: np.ndarray, period: np.ndarray, fixed: FixedCompensation
) -> tuple[np.ndarray, np.ndarray]:
    """gc_compensator: forces in mN (..., n) out, and whether each saturated; count and period (..., n)."""
    force_mn = np.asarray(force_mn, dtype=np.int64)
    total = force_mn + position_table(count, fixed) + friction(force_mn, period, fixed)
    return saturate(total, q.FORCE_BITS)


def period_of(v_mps: np.ndarray, drive: Drive) -> np.ndarray:
    """What gc_speed_meter gives at steady speeds v (..., n), m/s: signed clocks per 4 counts; at rest 2**31 - 1."""
    with np.errstate(divide="ignore"):  # at rest
        clocks = 4 * drive.clock_hz * drive.unit_per_count / np.abs(v_mps)
    known = np.clip(np.floor(np.where(np.isfinite(clocks), clocks, 0.0)), 1, 2**31 - 1).astype(np.int64)
    return np.where(np.isfinite(clocks) & (clocks < 2**31), np.where(np.asarray(v_mps) < 0, -known, known), 2**31 - 1)
