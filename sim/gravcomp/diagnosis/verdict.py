"""How much of the residual is explained, and whether that is all."""

import numpy as np

from gravcomp.diagnosis.fit import Fit
from gravcomp.diagnosis.samples.noise import Noise
from gravcomp.diagnosis.shares import Shares
from gravcomp.diagnosis.thresholds import MINOR_SHARE, REMAINDER, TINY


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


def verdict(fit: Fit, share: Shares, left: list[dict], over_noise: float) -> str:
    """nothing_missing, explained, partly_explained or unexplained.

    left: structure that is in the remainder; over_noise: the remainder over the noise that no model made. Corrections
    count by what they explain beside the effects.
    """
    is_more = bool(left) or over_noise > REMAINDER
    if not fit.effects:
        return "unexplained" if fit.corrections or is_more else "nothing_missing"
    if is_more or share.of_corrections > MINOR_SHARE * (1.0 - share.left):
        return "partly_explained"
    return "explained"
