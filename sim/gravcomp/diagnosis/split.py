"""Held-out samples, in blocks: neighbours in time, or in pose where poses are scattered, stay on one side."""

import numpy as np
from sklearn.cluster import KMeans

from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement

TEST_SHARE = 0.25


def block_labels(data: Measurement, seed: int) -> np.ndarray:
    """Block of each sample, (n,): stretches of time where poses follow each other, else clusters of poses."""
    n = len(data.t_s)
    if data.is_ordered:
        return (np.arange(n) * int(np.clip(n // 25, 8, 40))) // n
    scale = np.where(np.ptp(data.q, axis=0) > 0, np.ptp(data.q, axis=0), 1.0)
    n_clusters = min(int(np.clip(n // 12, 8, 40)), len(np.unique(data.q, axis=0)))
    return KMeans(n_clusters, n_init=1, random_state=seed).fit_predict(data.q / scale)


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
    order = np.random.default_rng(seed).permutation(np.unique(blocks))
    sizes = np.array([np.count_nonzero(blocks == b) for b in order])
    # never all of them, even where one block is most of the data
    chosen = order[:-1][: 1 + np.searchsorted(np.cumsum(sizes), TEST_SHARE * n)]
    return np.isin(blocks, chosen)
