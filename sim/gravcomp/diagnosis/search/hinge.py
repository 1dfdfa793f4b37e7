"""Scan for a corner: where a force begins that is nothing on one side, as a stop or a slack rope has it."""

import numpy as np

from gravcomp.diagnosis.thresholds import CORNER_ROWS, CORNERS, CORNERS_INSIDE, TINY

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


def _gains(x, y, corners, side, power) -> np.ndarray:
    """Square sum that the hinge of each corner takes off y, beside a constant."""
    hinge = np.maximum(side * (x[:, None] - corners), 0.0) ** power
    hinge -= hinge.mean(axis=0)
    return (y @ hinge) ** 2 / np.maximum(np.sum(hinge**2, axis=0), TINY)
