"""How much of the residual is explained, and whether that is all."""

import numpy as np

from gravcomp.diagnosis.fit import Fit
from gravcomp.diagnosis.samples.noise import Noise
from gravcomp.diagnosis.thresholds import MINOR_SHARE, REMAINDER, TINY
from gravcomp.logs.measurement import Measurement


def shares(data: Measurement, fit: Fit, use: np.ndarray, before: np.ndarray, after: np.ndarray) -> dict[str, float]:
    """Part of the variance before on the samples to use (n, k) that goes with each entry of the fit, by its name."""
    total, left = max(np.sum(before[use] ** 2), TINY), np.sum(after[use] ** 2)
    without = {entry.name: np.sum((after + entry.force(data))[use] ** 2) for entry in fit.entries}
    return {name: float(np.clip((energy - left) / total, 0.0, 1.0)) for name, energy in without.items()}


def remainder(after: np.ndarray, use: np.ndarray, is_test: np.ndarray, noise: Noise) -> float:
    """What is left over the noise that no model made: the worst of all axes together, held out, and of each axis.

    A single axis is known less well: three of its standard deviations are taken off.
    """
    held_out = after[is_test[:, None] & use]
    ratios = [np.sqrt(np.mean(held_out**2)) / max(noise.rms, TINY) if held_out.size else 0.0]
    for i in range(after.shape[1]):
        own = after[use[:, i], i]
        if len(own):
            ratio = np.sqrt(np.mean(own**2)) / max(noise.sigma[i], TINY)
            ratios.append(ratio * (1.0 - 3.0 / np.sqrt(max(len(own), 9))))
    return float(max(ratios))


def verdict(fit: Fit, share: dict[str, float], left: list[dict], over_noise: float) -> str:
    """nothing_missing, explained, partly_explained or unexplained.

    left: structure that is in the remainder; over_noise: the remainder over the noise that no model made.
    """
    known = sum(share[entry.name] for entry in fit.effects)
    other = sum(share[entry.name] for entry in fit.corrections)
    is_more = bool(left) or over_noise > REMAINDER
    if not fit.effects:
        return "unexplained" if fit.corrections or is_more else "nothing_missing"
    if is_more or other > MINOR_SHARE * (known + other):
        return "partly_explained"
    return "explained"
