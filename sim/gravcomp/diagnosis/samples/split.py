"""Held-out samples, in blocks: neighbours in time, or in pose where poses are scattered, stay on one side."""

import numpy as np
from sklearn.cluster import KMeans
from sklearn.model_selection import GroupKFold

from gravcomp.diagnosis.thresholds import (
    BLOCK_ROWS,
    BLOCKS,
    CLUSTER_ROWS,
    FEWEST_PLACES,
    FOLDS,
    MOST_HELD_OUT,
    MOSTLY_HOLDS,
    REPEATED,
    TEST_SHARE,
)
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement


def block_labels(data: Measurement, seed: int) -> np.ndarray:
    """Block of each sample, (n,): stretches of time where poses follow each other, else clusters of poses. A cluster of
    more than an eighth of the samples is a motion in a corner of where the holds are: it is divided along time.

    Rows of one pose are in one block; where there are too few poses to hold any out, blocks are stretches of time.
    """
    n = len(data.t_s)
    poses, of, count = np.unique(data.poses, axis=0, return_inverse=True, return_counts=True)
    is_repeated = len(poses) < REPEATED * n and data.is_motion.mean() < MOSTLY_HOLDS
    if (data.is_ordered and not is_repeated) or len(poses) < 2 * FEWEST_PLACES:
        return _stretches(n)
    scale = np.where(np.ptp(poses, axis=0) > 0, np.ptp(poses, axis=0), 1.0)
    n_clusters = min(int(np.clip(n // CLUSTER_ROWS, *BLOCKS)), len(poses) // 2)
    labels = KMeans(n_clusters, n_init=1, random_state=seed).fit_predict(poses / scale, sample_weight=count)[of.ravel()]
    for large in np.flatnonzero(np.bincount(labels) > n / BLOCKS[0]):
        moving = (labels == large) & data.is_motion
        labels[moving] = labels.max() + 1 + _stretches(np.count_nonzero(moving))
    return labels


def _stretches(n: int) -> np.ndarray:
    return (np.arange(n) * int(np.clip(n // BLOCK_ROWS, *BLOCKS))) // max(n, 1)


def folds(blocks: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Samples (train, test) of a cross-validation that leaves blocks (n,) whole; none where there are too few."""
    if len(np.unique(blocks)) < FOLDS:
        return []
    return list(GroupKFold(FOLDS).split(blocks, groups=blocks))


def held_out(data: Measurement, blocks: np.ndarray, seed: int, rule: str = "blocks") -> np.ndarray:
    """Mask of the samples that no fit sees, (n,).

    rule "blocks": a quarter of the blocks, drawn by seed; "reverse": every sample of the first axis moving backward;
    "last": the last quarter of the time. Raises InputError where axis 1 doesn't move both ways for "reverse".
    """
    n = len(data.t_s)
    if rule == "reverse":
        is_backward = np.zeros(n, bool) if data.v is None else data.v[:, 0] < 0
        if is_backward.all() or not is_backward.any():
            raise InputError(f"{data.name}: reverse can't be held out, as axis 1 doesn't move both ways; use blocks")
        return is_backward
    if rule == "last":
        return np.arange(n) >= round((1.0 - TEST_SHARE) * n)
    out = np.zeros(n, bool)
    for block in np.random.default_rng(seed).permutation(np.unique(blocks)):
        more = out | (blocks == block)
        if out.mean() < TEST_SHARE and more.mean() <= MOST_HELD_OUT and _leaves_enough(data, more):
            out = more
    if not out.any():  # one block is nearly all: its last rows
        out[round((1.0 - TEST_SHARE) * n) :] = True
    return out


def _leaves_enough(data: Measurement, is_test: np.ndarray) -> bool:
    every = len(np.unique(data.poses, axis=0))
    return len(np.unique(data.poses[~is_test], axis=0)) >= min(FEWEST_PLACES, every - 1)
