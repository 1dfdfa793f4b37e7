"""How much of a remainder can go with the direction of motion, and how much can be the same both ways.

A remainder r = e(q) + o(q) sign(v) + noise of an axis: between samples of nearly the same pose the mean product is
rho (E + O) where both moved the same way and rho (E - O) where they moved opposite ways, with the energies E of e and
O of o; no noise is in it, as no two samples share theirs. rho says how alike the two poses are. What neighbours do not
show to be of one half, the part 1 - rho, may be of either.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gravcomp.diagnosis.thresholds import NOISE_APART, NOISE_CANDIDATES, NOISE_ROWS
from gravcomp.logs.measurement import Measurement


@dataclass(frozen=True)
class Halves:
    """At most these parts (k,) of an energy change their sign with the direction, or keep it."""

    odd: np.ndarray
    even: np.ndarray

    def shared_with(self, other: "Halves") -> np.ndarray:
        """At most this part (k,) of it is of a half that the other surely has, half and half at least."""
        odd, even = (np.minimum(2.0 * own, 1.0) for own in (other.odd, other.even))
        return np.minimum(self.odd * odd + self.even * even, 1.0)


@dataclass(frozen=True)
class Neighbours:
    """Pairs of rows of nearly the same pose, by axis: that moved the same way, and opposite ways; rows (m,) of each."""

    pairs: tuple[tuple[np.ndarray, np.ndarray], ...]
    rows: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, data: Measurement, rows: np.ndarray) -> "Neighbours":
        rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), NOISE_ROWS)).astype(int)]
        own = tuple(rows[~data.is_undecided[rows, i]] for i in range(data.n_axes))
        ways = (1.0, -1.0) if data.has_velocity else ()
        return cls(tuple(tuple(_pairs(data, i, own[i], way) for way in ways) for i in range(data.n_axes)), own)

    def halves(self, force: np.ndarray, noise: np.ndarray) -> Halves:
        """Of force (n, k) beside noise (k,). Without directions, or pairs, all can be of either half."""
        odd, even = np.ones(len(noise)), np.ones(len(noise))
        for i, (own, pairs) in enumerate(zip(self.rows, self.pairs, strict=True)):
            f = force[:, i]
            energy = np.mean(f[own] ** 2) - noise[i] ** 2 if len(own) else 0.0
            if energy > 0.0 and pairs and all(len(here) for here, _ in pairs):
                same, opposite = (float(np.mean(f[here] * f[there]) / energy) for here, there in pairs)
                alike = np.clip(max(same, abs(opposite)), 0.0, 1.0)
                opposite = np.clip(opposite, -alike, alike)
                odd[i], even[i] = 1.0 - 0.5 * (alike + opposite), 1.0 - 0.5 * (alike - opposite)
        return Halves(odd, even)


def _pairs(data: Measurement, i: int, rows: np.ndarray, way: float) -> tuple[np.ndarray, np.ndarray]:
    """The rows (m,) and the nearest ones in pose that moved the same way (1) or the opposite one (-1)."""
    where, direction = data.scaled_positions, data.direction[:, i]
    apart, most = (max(NOISE_APART * len(where), 2.0), NOISE_CANDIDATES) if data.is_ordered else (1.0, 2)
    out = [np.zeros((2, 0), int)]
    for side in (1.0, -1.0):
        here, there = rows[direction[rows] == side], rows[direction[rows] == side * way]
        if len(here) and len(there):
            near = there[cKDTree(where[there]).query(where[here], range(1, min(most, len(there)) + 1))[1]]
            is_other = np.abs(near - here[:, None]) >= apart
            first = near[np.arange(len(here)), is_other.argmax(axis=1)]
            out.append(np.stack([here, first])[:, is_other.any(axis=1)])
    here, there = np.concatenate(out, axis=1)
    return here, there
