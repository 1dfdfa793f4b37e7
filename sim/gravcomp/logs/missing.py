"""Marks that stand for a missing value: one extreme number, far from all others, again and again."""

import numpy as np

_USUAL = (9999.0, -9999.0, 99999.0, -99999.0, 32767.0, -32768.0, 65535.0, 999.0, -999.0, 2147483647.0, -2147483648.0)
_FAR = 5.0
_MOST = 0.2  # of the rows: what stands in more is a value


def marks(values: np.ndarray) -> tuple[float, np.ndarray] | None:
    """The mark in a column (n,) and the mask of its rows; None without one.

    A mark is the lowest or highest value, larger in size than _FAR times any other, and stands there twice at least;
    a usual one may stand there once, and be farther from the others than their range.
    """
    for extreme in (values.max(), values.min()):
        own = values == extreme
        others = values[~own]
        reach = np.ptp(others) if len(others) else 0.0
        if reach == 0.0 or own.mean() > _MOST:
            continue
        is_usual = extreme in _USUAL
        is_far = np.abs(others - extreme).min() > reach if is_usual else abs(extreme) > _FAR * np.abs(others).max()
        if is_far and own.sum() >= 2 - is_usual:
            return float(extreme), own
    return None
