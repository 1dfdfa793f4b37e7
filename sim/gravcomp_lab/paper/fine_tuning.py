"""Training a network on a few measured points without over-fitting: start from one trained in simulation, stay near it.

The cost is |e|^2 + ridge |p - p_0|^2 in normalised units, p_0 the weights from simulation, minimised by Gauss-Newton
steps. The ridge, and which weights may move, are chosen by cross-validation on the points, never on test poses.
"""

from dataclasses import dataclass, replace

import numpy as np

from gravcomp.network.activation import gamma
from gravcomp.network.weights import Network
from gravcomp.parallel import one_blas_thread
from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Point, Problem

WAYS = ("output layer", "all weights")
RIDGES = tuple(10.0**k for k in range(-4, 5))
_FOLDS = 10
_STEPS = 8


@dataclass(frozen=True)
class Tuned:
    """A way of training: its network, the ridge that it chose, its RMS error in cross-validation, N."""

    way: str
    ridge: float
    validation_rms_n: float
    network: Network


def tune_by_validation(start: Network, q_m: np.ndarray, f_n: np.ndarray, way: str, seed: int) -> Tuned:
    """Choose the ridge by ten-fold cross-validation on q (n, 3), m, and f (n, 3), N; then train on all points."""
    fold = np.random.default_rng(seed).permutation(len(q_m)) % _FOLDS
    errors = []
    with one_blas_thread():
        for ridge in RIDGES:
            left_out = np.empty_like(f_n)
            for k in range(_FOLDS):
                network = fine_tune(start, q_m[fold != k], f_n[fold != k], ridge, way)
                left_out[fold == k] = network.forces(q_m[fold == k]) - f_n[fold == k]
            errors.append(float(np.sqrt(np.mean(left_out**2))))
        best = int(np.argmin(errors))
        return Tuned(way, RIDGES[best], errors[best], fine_tune(start, q_m, f_n, RIDGES[best], way))


def fine_tune(start: Network, q_m: np.ndarray, f_n: np.ndarray, ridge: float, way: str) -> Network:
    """Train the output layer or all weights of a network on q (n, 3), m, and f (n, 3), N."""
    y = (f_n - start.f_offset) / start.f_scale
    problem = Problem((q_m - start.q_offset) * start.q_scale, y, start.n_hidden, ACTIVATIONS["gamma"])
    first = np.concatenate(
        [np.c_[start.hidden_weights, start.hidden_bias].ravel(), np.c_[start.output_weights, start.output_bias].ravel()]
    )
    free = np.arange(problem.n_hidden_parameters if way == "output layer" else 0, len(first))
    weights = first.copy()
    for _ in range(_STEPS):
        normal, rhs = problem.normal_equations(_point(problem, weights))
        rhs = rhs - ridge * (weights - first)
        weights[free] += np.linalg.solve(normal[np.ix_(free, free)] + ridge * np.eye(len(free)), rhs[free])
    hidden, output = _layers(problem, weights)
    return replace(
        start,
        hidden_weights=hidden[:, :-1],
        hidden_bias=hidden[:, -1],
        output_weights=output[:, :-1],
        output_bias=output[:, -1],
    )


def _layers(problem: Problem, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    n = problem.n_hidden_parameters
    return weights[:n].reshape(problem.shapes[0]), weights[n:].reshape(problem.shapes[1])


def _point(problem: Problem, weights: np.ndarray) -> Point:
    hidden, output = _layers(problem, weights)
    sums = problem.inputs @ hidden.T
    act = np.c_[gamma(sums), np.ones(len(sums))]
    error = problem.y - act @ output.T
    return Point(hidden, output, sums, act, error, float(np.mean(error**2)))
