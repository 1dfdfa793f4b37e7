"""Scan for a corner: where a force begins that is nothing on one side, as a stop or a slack rope has it."""

from itertools import combinations

import numpy as np

from gravcomp.diagnosis.thresholds import CORNER_PAIRS, CORNER_ROWS, CORNER_TURNS, CORNERS, CORNERS_INSIDE, TINY

SIDES = (1.0, -1.0)


def corner_in(x: np.ndarray, y: np.ndarray, side: float, power: float) -> float | None:
    """The corner c at which max(side (x - c), 0)^power takes most off y - mean(y), x and y (n,); None where x has no
    room for one. A grid of quantiles, then the grid between the neighbours of the best.
    """
    if len(x) < CORNER_ROWS or np.ptp(x) == 0.0:
        return None
    corners = np.unique(np.quantile(x, np.linspace(*CORNERS_INSIDE, CORNERS)))
    for _ in range(2):
        best = int(_gains(x, y, corners, side, power).argmax())
        low, high = corners[max(best - 1, 0)], corners[min(best + 1, len(corners) - 1)]
        corners = np.linspace(low, high, 21)
    return float(corners[_gains(x, y, corners, side, power).argmax()])


def corners_in(x: np.ndarray, y: np.ndarray, power: float) -> tuple[float, float] | None:
    """The corners of a lower and an upper hinge that together take most off y - mean(y); None where x has no room for
    them. The best pair of a few quantiles, then each in turn on what the other one leaves.
    """
    if len(x) < CORNER_ROWS or np.ptp(x) == 0.0:
        return None
    pairs = combinations(np.quantile(x, np.linspace(*CORNERS_INSIDE, CORNER_PAIRS)), 2)
    corners = dict(zip((-1.0, 1.0), min(pairs, key=lambda pair: _ends(x, y, *pair, power)[1]), strict=True))
    for side in SIDES * CORNER_TURNS:
        ends, _ = _ends(x, y, corners[-1.0], corners[1.0], power)
        corners[side] = corner_in(x, y - ends[-side], side, power)
    return (corners[-1.0], corners[1.0]) if corners[-1.0] <= corners[1.0] else None


def _ends(x, y, low: float, high: float, power: float) -> tuple[dict[float, np.ndarray], float]:
    """Force of the hinge on each side, (n,), fitted to y together, and the square sum that they leave."""
    columns = np.column_stack([np.ones(len(x)), hinge(x, low, -1.0, power), hinge(x, high, 1.0, power)])
    theta = np.linalg.lstsq(columns, y, rcond=None)[0]
    return {-1.0: columns[:, 1] * theta[1], 1.0: columns[:, 2] * theta[2]}, float(np.sum((y - columns @ theta) ** 2))


def hinge(x: np.ndarray, corner, side: float, power: float) -> np.ndarray:
    """max(side (x - corner), 0)^power."""
    return np.maximum(side * (x - corner), 0.0) ** power


def _gains(x, y, corners, side, power) -> np.ndarray:
    """Square sum that the hinge of each corner takes off y, beside a constant."""
    columns = hinge(x[:, None], corners, side, power)
    columns -= columns.mean(axis=0)
    return (y @ columns) ** 2 / np.maximum(np.sum(columns**2, axis=0), TINY)
