"""A network trained on for its largest error: some of the mean square is given for it.

With errors e in N or N m, cost = mean e^2 / s^2 over poses of the workspace + mean |e/t|^p over these and the worst
poses found, t = 3/4 of the error wanted and s = t/3: the p-norm is felt beyond t alone. Each Gauss-Newton step weights
the rows by the cost's curvature, p (p - 1) |e|^(p-2) / t^p + 2/s^2 (Lawson's way to Chebyshev's approximation, damped
as in Levenberg-Marquardt). Between steps the worst poses of a large pool, half of them on the boundary of the
workspace, join. Hops that draw a neuron anew leave a poor minimum.
"""

from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from gravcomp.core.formats import quantise
from gravcomp.network.activation import gamma, gamma_slope
from gravcomp.network.weights import Network
from gravcomp.parallel import one_blas_thread
from gravcomp.robot.machine import Drive
from gravcomp.robot.protocol import HasBoundary, Robot
from gravcomp.training.scaling import Scaling
from gravcomp.training.training import as_network

N_LARGEST = 60000
_SHARE_OF_WANTED, _SPREAD = 0.75, 3.0
_FIRST_NORM, _HOP_NORM, _HOP_SHARE = 4, 10, 1.5  # norms that lead to p; the error wanted of the first, in parts
_POOL, _WORST = 60000, 300
_STEPS, _ROUNDS = 20, 6
_FELT = 0.5  # of t: smaller errors do not count in the p-norm's curvature
_MU_START, _MU_LEAST, _MU_MOST = 1e-3, 1e-9, 1e6
_ENOUGH = 1e-5  # of the cost: a smaller fall ends a round
_HOPELESS = 1.6  # times the best cost after the first steps of a hop
_REDRAWN, _BIAS_SPREAD = 1.5, 1.0


@dataclass(frozen=True)
class Cost:
    """mean e^2 / s^2 + mean |e/t|^p for an error wanted in N or N m."""

    norm: int
    wanted: float

    @property
    def t(self) -> float:
        return _SHARE_OF_WANTED * self.wanted

    @property
    def s(self) -> float:
        return self.t / _SPREAD


@dataclass(frozen=True)
class Weights:
    """hidden [W b_H] (h, n+1), output [V b_o] (m, h+1)."""

    hidden: np.ndarray
    output: np.ndarray

    def activations(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sums (N, h), and [h 1] (N, h+1), of inputs [x 1] (N, n+1)."""
        sums = x @ self.hidden.T
        return sums, np.c_[gamma(sums), np.ones(len(x))]

    def moved(self, step: np.ndarray) -> "Weights":
        n = self.hidden.size
        return Weights(
            self.hidden + step[:n].reshape(self.hidden.shape), self.output + step[n:].reshape(self.output.shape)
        )


class PoseRows:
    """Rows [x 1] (N, n+1), y (N, m) with scale (m,) to N or N m; the first n_base are of the workspace as drawn."""

    def __init__(self, x: np.ndarray, y: np.ndarray, scale: np.ndarray, n_base: int):
        self.x, self.y, self.scale, self.n_base = x, y, scale, n_base

    def errors(self, weights: Weights) -> np.ndarray:
        """(N, m), N or N m."""
        return self.scale * (self.y - weights.activations(self.x)[1] @ weights.output.T)

    def cost(self, error: np.ndarray, cost: Cost) -> float:
        share = 1.0 / (self.n_base * error.shape[1])
        square = np.sum(error[: self.n_base] ** 2) / cost.s**2
        return float(share * (square + np.sum(np.abs(error / cost.t) ** cost.norm)))

    def normal_equations(self, weights: Weights, error: np.ndarray, cost: Cost) -> tuple[np.ndarray, np.ndarray]:
        """Curvature and descent of the cost over all weights, output by output: each has weights of its own."""
        sums, act = weights.activations(self.x)
        slope, (h, n_in), m = gamma_slope(sums), weights.hidden.shape, len(weights.output)
        rows = np.concatenate([(slope[:, :, None] * self.x[:, None, :]).reshape(len(sums), -1), act], axis=1)
        n, share, p = h * n_in, 1.0 / (self.n_base * m), cost.norm
        base = rows[: self.n_base].T @ rows[: self.n_base]
        pull = share * p * np.sign(error) * np.abs(error / cost.t) ** (p - 1) / cost.t
        pull[: self.n_base] += share * 2.0 * error[: self.n_base] / cost.s**2
        normal, descent = np.zeros((n + m * (h + 1),) * 2), np.zeros(n + m * (h + 1))
        for k in range(m):
            felt = np.flatnonzero(np.abs(error[:, k]) > _FELT * cost.t)
            weight = share * p * (p - 1) * np.abs(error[felt, k] / cost.t) ** (p - 2) / cost.t**2
            gram = 2.0 * share / cost.s**2 * base + (rows[felt] * weight[:, None]).T @ rows[felt]
            gram, right = self.scale[k] ** 2 * gram, self.scale[k] * (rows.T @ pull[:, k])
            v, own = np.repeat(weights.output[k, :-1], n_in), slice(n + k * (h + 1), n + (k + 1) * (h + 1))
            normal[:n, :n] += np.outer(v, v) * gram[:n, :n]
            normal[:n, own] = v[:, None] * gram[:n, n:]
            normal[own, :n] = normal[:n, own].T
            normal[own, own] = gram[n:, n:]
            descent[:n] += v * right[:n]
            descent[own] = right[n:]
        return normal, descent


def descend(
    poses: PoseRows, weights: Weights, cost: Cost, steps: int, *, output_only: bool = False
) -> tuple[Weights, float]:
    """Damped Gauss-Newton steps down the cost, of all weights or those of the output; weights and cost at their end."""
    free = slice(weights.hidden.size if output_only else 0, None)
    mu, error = _MU_START, poses.errors(weights)
    value = poses.cost(error, cost)
    for _ in range(steps):
        normal, descent = poses.normal_equations(weights, error, cost)
        damping = np.diag(np.diag(normal) + 1e-12 * np.trace(normal))
        while mu < _MU_MOST:
            step = np.zeros(len(descent))
            step[free] = np.linalg.solve((normal + mu * damping)[free, free], descent[free])
            trial = weights.moved(step)
            trial_error = poses.errors(trial)
            trial_value = poses.cost(trial_error, cost)
            if trial_value < value:
                break
            mu *= 4.0
        else:
            break
        fell = value - trial_value
        weights, error, value, mu = trial, trial_error, trial_value, max(0.3 * mu, _MU_LEAST)
        if fell < _ENOUGH * value:
            break
    return weights, value


class _Search:
    """Training poses that grow by the worst of a pool, which is drawn anew every time: what is largest lies between the
    poses of any one draw.
    """

    def __init__(self, network: Network, robot: Robot, n_poses: int, seed: int):
        self.scaling = Scaling(*(getattr(network, name) for name in Scaling.__dataclass_fields__))
        self._robot, self._seed, self._n_base = robot, seed, n_poses
        self._x, self._y = self._rows(robot.workspace(n_poses, seed))

    def _rows(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.c_[self.scaling.x(q), np.ones(len(q))], self.scaling.y(self._robot.forces(q))

    @property
    def poses(self) -> PoseRows:
        return PoseRows(self._x, self._y, self.scaling.f_scale, self._n_base)

    def add_worst(self, weights: Weights, count: int = _WORST) -> None:
        self._seed += 2  # that of the boundary is one more
        x, y = self._rows(edge_and_inside(self._robot, _POOL, self._seed))
        error = np.abs(PoseRows(x, y, self.scaling.f_scale, 0).errors(weights)).max(axis=1)
        worst = np.argsort(-error)[:count]
        self._x, self._y = np.concatenate([self._x, x[worst]]), np.concatenate([self._y, y[worst]])

    def settle(self, weights: Weights, cost: Cost, rounds: int) -> tuple[Weights, float]:
        for _ in range(rounds):
            self.add_worst(weights)
            weights, value = descend(self.poses, weights, cost, _STEPS)
        return weights, value


def largest_error(network: Network, robot: Robot, seed: int, activation=gamma) -> float:
    """Largest error, N or N m, over N_LARGEST poses of the workspace and as many of its boundary: the more poses are
    looked at, the larger it is, and at the boundary it is largest.
    """
    q = edge_and_inside(robot, N_LARGEST, seed)
    return float(np.abs(network.forces(q, activation) - robot.forces(q)).max())


def edge_and_inside(robot: Robot, n_poses: int, seed: int) -> np.ndarray:
    """Poses (n, axes) of the workspace, and as many of its boundary where the robot knows it."""
    inside = robot.workspace(n_poses, seed)
    if not isinstance(robot, HasBoundary):
        return inside
    return np.concatenate([inside, robot.boundary(n_poses, seed + 1)])


def least_largest_error(
    network: Network, robot: Robot, drive: Drive, *, wanted: float, norm: int, n_poses: int, hops: int, seed: int
) -> Network:
    """The network trained on, on the hardware's grid. wanted: largest error, N or N m, over workspace and boundary;
    hops: neurons drawn anew. Raises InputError when the hardware cannot hold the weights.
    """
    search, rng = _Search(network, robot, n_poses, seed), np.random.default_rng(seed)
    weights = Weights(
        np.c_[network.hidden_weights, network.hidden_bias], np.c_[network.output_weights, network.output_bias]
    )
    with one_blas_thread():
        for p in range(_FIRST_NORM, _HOP_NORM + 1, 2):
            part = _HOP_SHARE + (1.0 - _HOP_SHARE) * (p - _FIRST_NORM) / (_HOP_NORM - _FIRST_NORM)
            weights, _ = search.settle(weights, Cost(p, part * wanted), _ROUNDS)
        weights = _hopped(search, weights, Cost(_HOP_NORM, wanted), hops, rng)
        for p in range(_HOP_NORM, norm + 1, 2):
            weights, _ = search.settle(weights, Cost(p, wanted), _ROUNDS)
        return _on_grid(search, weights, drive, Cost(norm, wanted))


def _hopped(search: _Search, weights: Weights, cost: Cost, hops: int, rng: np.random.Generator) -> Weights:
    weights, best = search.settle(weights, cost, 1)
    for _ in tqdm(range(hops), desc="largest error, hops", delay=2.0):
        poses, hidden = search.poses, weights.hidden.copy()
        neuron, (_, n_in) = rng.integers(len(hidden)), hidden.shape
        spread = np.r_[np.full(n_in - 1, _REDRAWN), _BIAS_SPREAD]
        if rng.random() < 0.7:
            hidden[neuron] = spread * rng.standard_normal(n_in)
        else:
            hidden += 0.06 * rng.standard_normal(hidden.shape) * np.abs(hidden)
        _, act = Weights(hidden, weights.output).activations(poses.x)
        ridge = 1e-6 * np.eye(act.shape[1])
        trial = Weights(hidden, np.linalg.solve(act.T @ act + ridge, act.T @ poses.y).T)
        trial, _ = descend(poses, trial, Cost(_FIRST_NORM, _HOP_SHARE * cost.wanted), 8)
        trial, value = descend(poses, trial, cost, 12)
        if value > _HOPELESS * best:
            continue
        trial, value = descend(poses, trial, cost, 30)
        if value < best - 1e-4:
            weights, best = search.settle(trial, cost, 1)
    return weights


def _on_grid(search: _Search, weights: Weights, drive: Drive, cost: Cost) -> Network:
    """Hidden weights rounded, then output weights trained for the same cost, then rounded."""
    fixed = quantise(as_network(weights.hidden, weights.output, search.scaling), drive)
    hidden = np.c_[fixed.hidden_weights * 2.0**-fixed.weight_fraction, weights.hidden[:, -1]]
    weights, _ = descend(search.poses, Weights(hidden, weights.output), cost, _STEPS, output_only=True)
    fixed = quantise(as_network(hidden, weights.output, search.scaling), drive)
    output = np.c_[fixed.output_weights * 2.0**-fixed.output_weight_fraction, weights.output[:, -1]]
    return as_network(hidden, output, search.scaling)
