"""Places at which an axis was held: positions on a grid, or visited again, gather there.

A controller without an integral stands off the place it was sent to by effort/stiffness. The deviation then is the
effort, read back; whoever lets a force depend on it explains anything.
"""

from dataclasses import dataclass

import numpy as np

_JUMP = 3.0  # gaps between places are at least this many times those within: random positions never show this
_FEWEST_WITHIN = 0.2  # of all gaps must lie within places
_EVEN = 0.3  # relative spread of the gaps of a grid whose places are visited once
_ONE_PLACE = 0.01  # of the range of the other axes: this axis was held still
_FEWEST = 8


@dataclass(frozen=True)
class Places:
    """centre (n,): of the place of each row; spacing: usual distance of neighbours; 0 with a single place."""

    centre: np.ndarray
    spacing: float

    @property
    def count(self) -> int:
        return len(np.unique(self.centre))


def places(q: np.ndarray, reach_of_others: float) -> Places | None:
    """Places of one axis' positions (n,), or None where they gather nowhere."""
    values = np.unique(q)
    if len(values) < 2 or np.ptp(q) < _ONE_PLACE * reach_of_others:
        return Places(np.full(len(q), np.median(q)), 0.0)
    gaps = np.diff(values)
    if len(gaps) < _FEWEST:
        return Places(q.astype(float), float(np.median(gaps)))
    if gaps.std() < _EVEN * gaps.mean():
        return Places(_on_grid(q, values), float(np.median(gaps)))
    ordered = np.sort(gaps)
    low = int(_FEWEST_WITHIN * len(ordered))
    ratio = ordered[low + 1 :] / np.maximum(ordered[low:-1], 1e-12 * np.ptp(q))
    if not len(ratio) or ratio.max() < _JUMP:
        return None
    limit = ordered[low + int(ratio.argmax())]
    of = np.concatenate([[0], np.cumsum(gaps > limit)])
    if of[-1] + 1 > 0.8 * len(values):
        return None
    first = np.flatnonzero(np.diff(of, prepend=-1))
    extent = values[np.append(first[1:], len(values)) - 1] - values[first]
    if extent.max() > gaps[gaps > limit].min():  # stretches of a motion, far apart: nobody was held there
        return None
    sums = np.bincount(of, values) / np.bincount(of)
    return Places(sums[of][np.searchsorted(values, q)], float(np.median(np.diff(sums))) if len(sums) > 1 else 0.0)


def _on_grid(q: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The nearest points of the even grid through the values."""
    number = np.arange(len(values))
    step, start = np.polyfit(number, values, 1)
    return start + step * np.rint((q - start) / step)
