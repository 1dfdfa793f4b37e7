"""Search for a good minimum: many short Levenberg-Marquardt runs, then basin hopping from the best.

The cost of a small network has many local minima; one start ends in a poor one more often than not. Basin hopping
(Wales and Doye, 1997) disturbs the best network, descends again and keeps what is better or hardly worse.
"""

import numpy as np

from gravcomp.training.levenberg_marquardt import Problem, Stop, Trained, levenberg_marquardt
from gravcomp.training.waves import Waves

# Hidden weights stay below this, so that 18-bit codes keep 15 fraction bits; waves may need steeper ones.
WEIGHT_LIMIT = 4.0
# Inputs lie in [-1, 1]^n: with |w| = |b| = 2.5 a neuron bends and saturates inside the cube.
_REACH = 2.5

_DRAW = Stop(steps=120)
_PROBE, _PROBE_FACTOR = Stop(steps=40, stall=1e-2, stall_steps=20), 1.25
_SETTLE = Stop(steps=100)
_HEAT = 0.03  # a hop may raise the cost by this fraction, on average
_PATIENCE = 300  # hops without a new best before returning to it


def random_hidden(n_hidden: int, n_inputs: int, rng: np.random.Generator) -> np.ndarray:
    """Random hidden parameters [W b_H] (h, n+1): directions uniform, |w| = 2.5, bias uniform in [-2.5, 2.5]."""
    direction = rng.standard_normal((n_hidden, n_inputs))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return _REACH * np.c_[direction, rng.uniform(-1.0, 1.0, n_hidden)]


def best_of_draws(problem: Problem, n_draws: int, rng: np.random.Generator, waves: Waves | None = None) -> Trained:
    """The best of n_draws short runs from random starts, along waves where they are given; small weights first."""
    n_hidden, n_columns = problem.shapes[0]
    fits = []
    for _ in range(n_draws):
        start = waves.hidden(n_hidden, rng) if waves else random_hidden(n_hidden, n_columns - 1, rng)
        fits.append(levenberg_marquardt(problem, start, _DRAW))
    return min(fits, key=lambda fit: (not _is_small(fit, waves), fit.cost))


def basin_hopping(
    problem: Problem, fit: Trained, n_hops: int, rng: np.random.Generator, waves: Waves | None = None
) -> Trained:
    """The best network found by n_hops hops from fit; waves: whose slopes weights may have."""
    best = current = fit
    idle = 0
    for _ in range(n_hops):
        trial = levenberg_marquardt(problem, _disturbed(current.hidden, problem.neurons, rng), _PROBE)
        if trial.cost < _PROBE_FACTOR * current.cost:
            trial = levenberg_marquardt(problem, trial.hidden, _SETTLE)
        idle += 1
        if _is_small(trial, waves) and trial.cost < current.cost * (1.0 + _HEAT * rng.exponential()):
            current = trial
        if current.cost < best.cost:
            best, idle = current, 0
        elif idle > _PATIENCE:
            current, idle = best, 0
    return best


def _disturbed(hidden: np.ndarray, neurons: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Hidden parameters with some of the given neurons moved: one replaced, a few shaken, or all shaken a little.

    A replacement mostly takes the direction of another neuron, with a slope and an offset of its own: good networks of
    this robot bundle their neurons along a few directions, the normals of the singular faces.
    """
    hidden = hidden.copy()
    n_columns = hidden.shape[1]
    kind = rng.choice(4, p=[0.45, 0.1, 0.2, 0.25])
    if kind == 0:
        direction = hidden[rng.integers(len(hidden)), :-1]
        slope = np.exp(rng.uniform(*np.log([0.5, 1.6 * WEIGHT_LIMIT])))
        direction = direction / np.linalg.norm(direction)
        hidden[rng.choice(neurons)] = slope * np.r_[direction, rng.uniform(-1.2, 1.2)]
    elif kind == 1:
        hidden[rng.choice(neurons)] = random_hidden(1, n_columns - 1, rng)[0] * rng.uniform(0.3, 1.6)
    elif kind == 2:
        chosen = rng.choice(neurons, min(3, len(neurons)), replace=False)
        hidden[chosen] += rng.choice([0.2, 0.5]) * rng.standard_normal((len(chosen), n_columns))
    else:
        hidden[neurons] += rng.choice([0.03, 0.1, 0.2]) * rng.standard_normal((len(neurons), n_columns))
    return hidden


def _is_small(fit: Trained, waves: Waves | None) -> bool:
    limit = max(WEIGHT_LIMIT, 2.0 * float(np.abs(waves.directions).max())) if waves else WEIGHT_LIMIT
    return bool(np.abs(fit.hidden[:, :-1]).max() < limit)
