"""The largest error that a search finds: the bit-true core against the statics, at poses and around the worst."""

from collections.abc import Callable

import numpy as np

N_POSES = 100_000
_N_BEST, _ROUNDS, _SHRINK, _REACH = 32, 60, 0.85, 0.1
_ON_FACE = 0.2  # of the random poses, per variable: errors are largest at the edge more often than not


class WorstPose:
    """The largest error of each axis so far, (n,), and the parameters (n, k) of its pose."""

    def __init__(self, errors: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray):
        self._errors, self._low, self._high = errors, low, high
        n = errors((low + high)[None] / 2).shape[1]
        self.size, self.parameters = np.zeros(n), np.tile((low + high) / 2, (n, 1))

    def look_at(self, parameters: np.ndarray) -> np.ndarray:
        """Errors' sizes (N, n) at parameters (N, k), the largest of which are kept."""
        sizes = np.abs(self._errors(parameters))
        best = sizes.argmax(axis=0)
        for axis, row in enumerate(best):
            if sizes[row, axis] > self.size[axis]:
                self.size[axis], self.parameters[axis] = sizes[row, axis], parameters[row]
        return sizes

    def search(self, n_poses: int, seed: int) -> None:
        """Random poses, some on the faces of the box; from the worst for each axis, random steps that get shorter."""
        rng, k = np.random.default_rng(seed), len(self._low)
        at = rng.uniform(self._low, self._high, (n_poses, k))
        ends = np.where(rng.random(at.shape) < 0.5, self._low, self._high)
        at = np.where(rng.random(at.shape) < _ON_FACE, ends, at)
        sizes = self.look_at(at)
        for axis in range(sizes.shape[1]):
            self._climb(at[np.argsort(-sizes[:, axis])[:_N_BEST]], axis, rng)

    def _climb(self, place: np.ndarray, axis: int, rng: np.random.Generator) -> None:
        value, reach = self.look_at(place)[:, axis], _REACH * (self._high - self._low)
        for _ in range(_ROUNDS):
            trial = np.clip(place + reach * rng.standard_normal(place.shape), self._low, self._high)
            found = self.look_at(trial)[:, axis]
            better = found > value
            place, value = np.where(better[:, None], trial, place), np.where(better, found, value)
            reach = reach * _SHRINK
