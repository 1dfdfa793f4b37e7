"""Gross errors: single samples far from all that lies beside them."""

import numpy as np
from scipy.spatial import cKDTree

from gravcomp.diagnosis.thresholds import GROSS, GROSS_NEAR, GROSS_SHARE, GROSS_SIDE, MAD_TO_SIGMA, TINY
from gravcomp.logs.measurement import Measurement


def spread(values: np.ndarray) -> np.ndarray:
    """Robust standard deviation of each column of (m, k)."""
    return MAD_TO_SIGMA * np.median(np.abs(values - np.median(values, axis=0)), axis=0)


def gross(data: Measurement, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Mask (m, k) of the gross errors in values (m, k) at the given rows.

    A sample is one when it lies outside the range that its neighbours span by more than GROSS robust standard
    deviations, and so few are that they can't be a part of the machine: a step, a stop, a jump at a reversal have
    neighbours of their kind.
    """
    if len(rows) < 2 * GROSS_NEAR:
        return np.zeros(values.shape, bool)
    low, high = _beside(values) if data.is_ordered else _around(data.scaled_positions[rows], values)
    scale = np.maximum(spread(values), 1e-6 * spread(data.force[rows])) + TINY
    outside = np.maximum(low - values, values - high) > GROSS * scale
    outside[:, outside.mean(axis=0) > GROSS_SHARE] = False
    return outside


def _beside(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Range of the medians before and after each sample."""
    padded = np.pad(values, ((GROSS_SIDE, GROSS_SIDE), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, GROSS_SIDE, axis=0)
    before = np.median(windows[: len(values)], axis=-1)
    after = np.median(windows[GROSS_SIDE + 1 : GROSS_SIDE + 1 + len(values)], axis=-1)
    return np.minimum(before, after), np.maximum(before, after)


def _around(positions: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    near = cKDTree(positions).query(positions, GROSS_NEAR + 1)[1][:, 1:]
    ordered = np.sort(values[near], axis=1)
    return ordered[:, 2], ordered[:, -3]
