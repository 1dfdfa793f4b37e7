"""Bounds of a robot's efforts over its workspace, where no formula gives them."""

from collections.abc import Callable

import numpy as np

from gravcomp.robot.ranges import Box, Poses

_N_POSES, _SEED = 8000, 20
_N_BEST, _ROUNDS, _SHRINK = 12, 24, 0.75
_NOTHING = 1e-9  # of the largest effort
_MARGIN = 0.005  # of the range of efforts: what the search may have missed


def effort_bounds(forces: Callable[[np.ndarray], np.ndarray], area: Box | Poses) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest effort of each axis, (n,) each, a little outward; forces: (N, n) to (N, n).

    Over all rows of a file of poses; in a box from random poses, and from the best of them, for every axis and end, by
    random steps that get shorter. Raises PoseError.
    """
    if isinstance(area, Poses):
        f = forces(area.q)
        return _outward(f.min(axis=0), f.max(axis=0))
    rng, n = np.random.default_rng(_SEED), len(area.low)
    q = area.sample(_N_POSES, _SEED)
    f = forces(q)
    signs = np.repeat([-1.0, 1.0], n)  # an end per row: lowest of each axis, then highest
    ends = np.concatenate([-f, f], axis=1)  # (N, 2n), each to be made large
    best = np.argsort(-ends, axis=0)[:_N_BEST].T  # (2n, k)
    place, value = q[best], np.take_along_axis(ends.T, best, axis=1)
    reach = (area.high - area.low) / 4
    for _ in range(_ROUNDS):
        trial = np.clip(place + reach * rng.standard_normal(place.shape), area.low, area.high)
        found = forces(trial.reshape(-1, n)).reshape(*trial.shape[:2], n)
        found = signs[:, None] * found[np.arange(2 * n), :, np.tile(np.arange(n), 2)]
        better = found > value
        place, value = np.where(better[..., None], trial, place), np.where(better, found, value)
        reach = reach * _SHRINK
    least, most = -value[:n].max(axis=1), value[n:].max(axis=1)
    return _outward(least, most)


def _outward(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A little beyond what was found; an axis that bears nothing but rounding bears nothing."""
    spare = _MARGIN * (high - low)
    is_borne = np.maximum(-low, high) > _NOTHING * np.abs([low, high]).max()
    return np.where(is_borne, low - spare, 0.0), np.where(is_borne, high + spare, 0.0)
