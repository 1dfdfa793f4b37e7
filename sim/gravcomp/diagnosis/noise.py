"""The noise of a log that no model made: differences of samples that the machine cannot tell apart.

Half the mean square of the difference between a sample and its nearest neighbour in position, direction and speed
(never one beside it in time) is the variance of the noise, and of all that the log's variables don't decide. It is
taken of the residual, whose model part hardly changes between neighbours.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gravcomp.diagnosis.thresholds import NEIGHBOUR_FAR, NOISE_SAMPLES
from gravcomp.logs.measurement import Measurement

_SPEED = 0.3  # weight of a speed beside a position: friction varies less with it
_CANDIDATES = 24
_APART = 0.02  # of the log: samples nearer in time are no repeats, their noise may be the same


@dataclass(frozen=True)
class Noise:
    """sigma (k,), and where it comes from; ``is_sure``: repeats or near neighbours there are."""

    sigma: np.ndarray
    source: str
    is_sure: bool

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.sigma**2)))


def model_free(data: Measurement, residual: np.ndarray, keep: np.ndarray) -> Noise:
    """residual (n, k); keep (n,): rows without gross errors and of a known direction."""
    rows = np.flatnonzero(keep)
    if len(rows) < NOISE_SAMPLES:
        return Noise(residual[rows].std(axis=0), f"the remainder itself: fewer than {NOISE_SAMPLES} samples", False)
    where = _state(data)[rows]
    distance, near = cKDTree(where).query(where, min(_CANDIDATES, len(rows)))
    apart = np.abs(rows[near] - rows[:, None])
    least = max(int(_APART * len(data.t_s)), 2) if data.is_ordered else 1
    is_other = apart >= least
    pick = is_other.argmax(axis=1)
    has = is_other.any(axis=1)
    index = np.flatnonzero(has)
    if len(index) < NOISE_SAMPLES:
        return Noise(_beside(residual[rows]), "differences of neighbours in time: no pose was passed again", False)
    partner, away = near[index, pick[index]], distance[index, pick[index]]
    difference = residual[rows[index]] - residual[rows[partner]]
    sigma = np.sqrt(np.mean(difference**2, axis=0) / 2.0)
    if np.median(away) < 1e-3:
        return Noise(sigma, "repeats of a pose", True)
    if np.median(away) < NEIGHBOUR_FAR:
        return Noise(sigma, "neighbours in pose and speed", True)
    return Noise(sigma, "neighbours in pose, far ones: the log has neither repeats nor near neighbours", False)


def _state(data: Measurement) -> np.ndarray:
    """What decides the effort of a sample: positions in parts of the range, directions, speeds."""
    parts = [data.scaled_positions]
    if data.has_velocity:
        usual = np.quantile(np.abs(data.v), 0.95, axis=0)
        parts += [data.direction, _SPEED * data.v / np.where(usual > 0.0, usual, 1.0)]
    return np.hstack(parts)


def _beside(residual: np.ndarray) -> np.ndarray:
    """Second differences along time: sigma of white noise, whatever is smooth beside it."""
    return np.sqrt(np.mean(np.diff(residual, 2, axis=0) ** 2, axis=0) / 6.0)
