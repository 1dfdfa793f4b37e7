"""The noise of a log that no model made: differences of samples that the machine cannot tell apart.

Each estimate is the noise and something beside it, so the least of them is taken, axis by axis:

- in time: second differences r(t-h) - 2 r(t) + r(t+h) within one direction, whose variance is six times that of the
  noise whatever is smooth beside it; the largest over strides h within which the pose hardly moves, as noise that
  is correlated over a few samples shows at the longer ones only;
- in pose: half the mean square of the difference to the p-th nearest neighbour in position, direction and speed,
  never one beside it in time, drawn over p to distance zero (the Gamma test: Evans and Jones, Proc. R. Soc. A 458,
  2002) where the line surely rises: drawn through noise alone it ends anywhere.

It is taken of the residual, whose model part hardly changes between neighbours.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gravcomp.diagnosis.thresholds import (
    MAD_TO_SIGMA,
    NEAR_NEIGHBOUR,
    NOISE_APART,
    NOISE_CANDIDATES,
    NOISE_GROUPS,
    NOISE_LEAST,
    NOISE_NEIGHBOURS,
    NOISE_RISES,
    NOISE_ROWS,
    NOISE_SAMPLES,
    NOISE_SPEED,
    NOISE_STRIDE,
    NOISE_STRIDES,
    NOISE_WINSOR,
    SAME_POSE,
)
from gravcomp.logs.measurement import Measurement


@dataclass(frozen=True)
class Noise:
    """sigma (k,), and where it comes from; ``is_sure``: repeats, near neighbours or a motion there are."""

    sigma: np.ndarray
    source: str
    is_sure: bool

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.sigma**2)))


@dataclass(frozen=True)
class _Estimate:
    sigma: float
    source: str
    is_sure: bool = True


def model_free(data: Measurement, residual: np.ndarray, keep: np.ndarray) -> Noise:
    """residual (n, k); keep (n, k): no gross errors, and of a known direction."""
    best = [_of_axis(data, i, residual[:, i], keep[:, i]) for i in range(data.n_axes)]
    source = " and ".join(dict.fromkeys(own.source for own in best))
    return Noise(np.array([own.sigma for own in best]), source, all(own.is_sure for own in best))


def _of_axis(data: Measurement, i: int, r: np.ndarray, keep: np.ndarray) -> _Estimate:
    found = [_in_time(data, i, r, keep), _in_pose(data, i, r, keep, [i])]
    if data.n_axes > 1 and data.has_velocity:
        found.append(_in_pose(data, i, r, keep, range(data.n_axes)))
    found = [own for own in found if own is not None]
    if not found:
        few = f"the remainder itself: fewer than {NOISE_SAMPLES} samples that can be compared"
        return _Estimate(float(r[keep].std()) if keep.any() else 0.0, few, False)
    least = min(found, key=lambda own: own.sigma)
    return least if least.is_sure else _Estimate(least.sigma, least.source, any(own.is_sure for own in found))


def _in_time(data: Measurement, i: int, r: np.ndarray, keep: np.ndarray) -> _Estimate | None:
    n, run = len(r), data.runs
    direction = data.direction[:, i] if data.has_velocity else np.zeros(n)
    position, found = data.scaled_positions, []
    for h in range(1, min(NOISE_STRIDES, (n - 1) // 2) + 1):
        if h > 1 and data.is_ordered and np.median(np.abs(position[h:] - position[:-h]).max(axis=1)) > NOISE_STRIDE:
            break
        before, at, after = slice(0, n - 2 * h), slice(h, n - h), slice(2 * h, n)
        use = keep[before] & keep[at] & keep[after] & (run[before] == run[after])
        if data.is_ordered:
            use &= (direction[before] == direction[at]) & (direction[at] == direction[after])
        if use.sum() >= NOISE_SAMPLES:
            found.append(_scale((r[before] - 2.0 * r[at] + r[after])[use]) / np.sqrt(6.0))
    if not found:
        return None
    source = "differences of neighbours in time"
    return _Estimate(max(found), source if data.is_ordered else f"{source}, whose poses differ", data.is_ordered)


def _in_pose(data: Measurement, i: int, r: np.ndarray, keep: np.ndarray, moving) -> _Estimate | None:
    """moving: axes whose direction and speed count, beside all positions."""
    rows = np.flatnonzero(keep)
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), NOISE_ROWS)).astype(int)] if len(rows) else rows
    if len(rows) < NOISE_SAMPLES:
        return None
    where = _state(data, moving)[rows]
    distance, near = cKDTree(where).query(where, min(NOISE_CANDIDATES, len(rows)))
    apart = max(NOISE_APART * len(r), 2.0) if data.is_ordered else 1.0
    is_other = np.abs(rows[near] - rows[:, None]) >= apart
    rank = np.cumsum(is_other, axis=1)
    pairs = [np.nonzero(is_other & (rank == p)) for p in range(1, NOISE_NEIGHBOURS + 1)]
    pairs = [(row, column) for row, column in pairs if len(row) >= max(0.5 * len(rows), NOISE_SAMPLES)]
    if not pairs:
        return None
    away = [np.mean(distance[pair] ** 2) for pair in pairs]
    difference = [r[rows[row]] - r[rows[near[row, column]]] for row, column in pairs]
    half = [_scale(own) ** 2 / 2.0 for own in difference]
    if np.sqrt(away[0]) < SAME_POSE:
        return _Estimate(float(np.sqrt(half[0])), "repeats of a pose")
    is_near = np.sqrt(away[0]) < NEAR_NEIGHBOUR
    if len(half) < NOISE_NEIGHBOURS or (data.is_ordered and not is_near):  # a line through few passes goes too low
        return _Estimate(float(np.sqrt(half[0])), "neighbours in pose, far ones", False)
    stretch = [row * NOISE_GROUPS // len(rows) for row, _ in pairs]
    at_zero = max(_at_distance_zero(away, difference, stretch), NOISE_LEAST * half[0])
    source = "neighbours in pose and speed" if is_near else "neighbours in pose, far ones"
    return _Estimate(float(np.sqrt(at_zero)), source, bool(is_near))


def _at_distance_zero(away: list[float], difference: list[np.ndarray], stretch: list[np.ndarray]) -> float:
    """Half the mean square of differences at distance zero: from the line over the squared distances ``away`` of the
    p-th neighbours, or from the mean where the line does not surely rise. stretch: of the log, of each difference.

    How sure it is tells the jackknife: neighbours share their samples, so their differences are not independent.
    """

    def mean_and_rise(without: int) -> tuple[float, float]:
        half = [_scale(own[of != without]) ** 2 / 2.0 for own, of in zip(difference, stretch, strict=True)]
        return float(np.mean(half)), float(np.mean(half) - np.polyval(np.polyfit(away, half, 1), 0.0))

    mean, rise = mean_and_rise(-1)
    rises = np.array([mean_and_rise(group)[1] for group in range(NOISE_GROUPS)])
    error = np.sqrt((NOISE_GROUPS - 1) * rises.var())
    return mean - rise if rise > NOISE_RISES * error else mean


def _state(data: Measurement, moving) -> np.ndarray:
    """What decides the effort of an axis: positions in parts of the range, directions and speeds of axes that move."""
    parts = [data.scaled_positions]
    if data.has_velocity:
        own = list(moving)
        usual = np.quantile(np.abs(data.v[:, own]), 0.95, axis=0)
        parts += [data.direction[:, own], NOISE_SPEED * data.v[:, own] / np.where(usual > 0.0, usual, 1.0)]
    return np.hstack(parts)


def _scale(d: np.ndarray) -> float:
    """Root mean square of d (m,) with values beyond NOISE_WINSOR of it drawn in: the jumps of a few pairs."""
    size = np.abs(d)
    scale = MAD_TO_SIGMA * np.median(size) or size.std()
    for _ in range(10):
        scale = np.sqrt(np.mean(np.minimum(size, NOISE_WINSOR * scale) ** 2))
    return float(scale)
