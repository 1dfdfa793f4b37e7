"""Directions in which a rotary chain's efforts bend, to start neurons from.

The weight of a serial chain is a sum of waves sin(d . q + phase) with d of -1, 0 and 1: every product of two sines is
one of sum and difference. Matching pursuit finds the few that matter; parallel axes show up as their sums. A neuron
with weights along d is half a wave of it.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from gravcomp.network.inputs import POSITION
from gravcomp.training.scaling import Scaling

_N_WAVES, _N_POSES = 12, 1500
_LEAST_EXPLAINED = 0.9  # of the variance of the efforts, or they are no waves: a closed chain, say
_HALF_WAVE = 4.0 / np.pi  # Gamma rises from -1 to 1 over 4, a sine over pi
_SPREAD = 0.3  # of the logarithm of that


@dataclass(frozen=True)
class Waves:
    """directions (k, n) of x, per half a wave; shares (k,) of neurons; x (N, n): poses to put the bends at."""

    directions: np.ndarray
    shares: np.ndarray
    x: np.ndarray

    def hidden(self, n_hidden: int, rng: np.random.Generator) -> np.ndarray:
        """Random hidden parameters [W b_H] (h, n+1): half waves whose middle is at a random pose."""
        chosen = rng.choice(len(self.shares), n_hidden, p=self.shares)
        weights = self.directions[chosen] * np.exp(rng.uniform(-_SPREAD, _SPREAD, n_hidden))[:, None]
        middle = self.x[rng.integers(len(self.x), size=n_hidden)]
        return np.c_[weights, -(weights * middle).sum(axis=1)]


def waves_of(q: np.ndarray, y: np.ndarray, scaling: Scaling, felt: np.ndarray) -> Waves | None:
    """The waves of normalised efforts y (N, m) at q (N, n), m or rad, over the axes that are felt (n,); None where they
    are not made of waves, or an axis is seen as sine and cosine."""
    is_wave = felt & np.array([unit == "rad" for unit in scaling.position_units])
    if is_wave.sum() < 2 or any(kind != POSITION for kind in np.array(scaling.inputs)[felt]):
        return None
    q, y = q[:_N_POSES], y[:_N_POSES]
    signs = np.array([d for d in product((-1, 0, 1), repeat=int(is_wave.sum())) if next(filter(None, d), 0) > 0])
    every = np.zeros((len(signs), len(is_wave)))
    every[:, is_wave] = signs
    chosen, amplitude, explained = _pursuit(q @ every.T, y)
    if explained < _LEAST_EXPLAINED:
        return None
    directions = every[chosen]
    turns = np.ptp(q @ directions.T, axis=0) / np.pi  # half waves within the ranges
    weight = np.sqrt(amplitude) * (turns + 1.0)
    x = (q - scaling.q_offset) * scaling.q_scale
    return Waves((_HALF_WAVE * directions / scaling.q_scale)[:, felt], weight / weight.sum(), x[:, felt])


def _pursuit(angle: np.ndarray, y: np.ndarray) -> tuple[list[int], np.ndarray, float]:
    """Columns of angle (N, K) whose sines and cosines make up y best, one by one; amplitudes; variance explained."""
    cosine, sine = np.cos(angle), np.sin(angle)
    basis, left, chosen = np.ones((len(y), 1)), y - y.mean(axis=0), []
    variance = float((left**2).sum())
    for _ in range(min(_N_WAVES, angle.shape[1])):
        score = ((cosine.T @ left) ** 2).sum(axis=1) + ((sine.T @ left) ** 2).sum(axis=1)
        score[chosen] = -1.0
        chosen.append(int(score.argmax()))
        basis = np.c_[basis, cosine[:, chosen[-1]], sine[:, chosen[-1]]]
        parts = np.linalg.lstsq(basis, y, rcond=None)[0]
        left = y - basis @ parts
    amplitude = np.sqrt((parts[1:].reshape(len(chosen), -1) ** 2).sum(axis=1))
    return chosen, amplitude, 1.0 - float((left**2).sum()) / variance if variance else 0.0
