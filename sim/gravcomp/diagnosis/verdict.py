"""How much of the residual is explained, and whether that is all."""

import numpy as np

from gravcomp.diagnosis.fit import Fit
from gravcomp.diagnosis.thresholds import MINOR_SHARE, TINY
from gravcomp.logs.measurement import Measurement


def shares(data: Measurement, fit: Fit, is_test: np.ndarray, before: np.ndarray, after: np.ndarray) -> dict[str, float]:
    """Part of the held-out residual's variance that goes with each entry of the fit, by its name."""
    total, left = max(np.sum(before[is_test] ** 2), TINY), np.sum(after[is_test] ** 2)
    without = {entry.name: np.sum((after + entry.force(data))[is_test] ** 2) for entry in fit.entries}
    return {name: float(np.clip((energy - left) / total, 0.0, 1.0)) for name, energy in without.items()}


def verdict(fit: Fit, share: dict[str, float], left: list[dict]) -> str:
    """nothing_missing, explained, partly_explained or unexplained; left: structure that is in the remainder."""
    known = sum(share[entry.name] for entry in fit.effects)
    other = sum(share[entry.name] for entry in fit.corrections)
    if not fit.effects:
        return "unexplained" if fit.corrections or left else "nothing_missing"
    if left or other > MINOR_SHARE * (known + other):
        return "partly_explained"
    return "explained"
