"""Levenberg-Marquardt training of a network with one hidden layer, y = V act(W x + b_H) + b_o.

Each step solves (J^T J + mu D) dp = J^T e and is taken when the cost falls; mu then falls too, otherwise it rises
(Hagan and Menhaj, 1994). Two additions, both standard:

- The output layer enters linearly. Only hidden parameters are damped (D), and the output layer is solved again after
  every step: variable projection (Golub and Pereyra, 2003) in Kaufman's form.
- Parameters may be tied, p = T z with one 1 per row of T, so that a symmetry of the data holds exactly.

J has the rows [V_kj act'_j x_a | h_j] for output k, so J^T J needs only V and B^T B with B = [act'_j x_a | h_j]: one
product for all outputs, many times cheaper than J itself. The output layer's own equations are eliminated before the
step: with B^T B = [A C; C^T G] what is left is (V^T V) * (A - C G^-1 C^T), elementwise, over the hidden parameters.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from gravcomp.network.activation import gamma, gamma_slope

# Columns of B from which single precision makes B^T B: the step is damped and its cost is looked at in double, anyway.
_SINGLE_FROM = 400

MU_START, MU_FALL, MU_RISE, MU_MIN, MU_MAX = 1e-2, 0.2, 4.0, 1e-12, 1e10


@dataclass(frozen=True)
class Activation:
    """Function and derivative of a hidden neuron, elementwise."""

    value: Callable[[np.ndarray], np.ndarray]
    slope: Callable[[np.ndarray], np.ndarray]


ACTIVATIONS = {
    "gamma": Activation(gamma, gamma_slope),
    "tanh": Activation(np.tanh, lambda x: 1.0 - np.tanh(x) ** 2),
}


@dataclass(frozen=True)
class Stop:
    """When to stop: norm of dMSE/dp below gradient, `steps` taken, or the cost fell by less than the fraction `stall`
    over stall_steps. Gradient and MSE in the units of y."""

    gradient: float = 0.0
    steps: int = 1000
    stall: float = 1e-4
    stall_steps: int = 30


@dataclass(frozen=True)
class Trained:
    """A trained network on normalised data.

    hidden: [W b_H] (h, n+1); output: [V b_o] (m, h+1); mse: mean of e^2 over rows and outputs; cost: mse and ridge;
    gradient: norm of dMSE/dp, p the free parameters; steps taken; reason: "gradient", "stall", "steps", or "damping"
    when no step however small lowers the cost.
    """

    hidden: np.ndarray
    output: np.ndarray
    mse: float
    cost: float
    gradient: float
    steps: int
    reason: str


@dataclass(frozen=True)
class Point:
    """Network and errors at one set of parameters: sums W x + b_H (N, h), act [h 1] (N, h+1), error (N, m)."""

    hidden: np.ndarray
    output: np.ndarray
    sums: np.ndarray
    act: np.ndarray
    error: np.ndarray
    cost: float


class Problem:
    """Cost and normal equations of one data set.

    x (N, n), y (N, m): normalised data. tie: for every parameter of [hidden.ravel(), output.ravel()] the index of its
    free parameter, hidden ones first (default: all free). ridge: weight of the mean square of V in the cost
    ``mean e^2 + ridge mean_k |V_k|^2``: it keeps V small where the data leave it undetermined.
    """

    def __init__(self, x, y, n_hidden: int, activation: Activation, tie=None, ridge: float = 0.0):
        self.inputs = np.c_[x, np.ones(len(x))]
        self.y = y
        self.activation = activation
        self.shapes = (n_hidden, self.inputs.shape[1]), (y.shape[1], n_hidden + 1)
        self.n_hidden_parameters = n_hidden * self.inputs.shape[1]
        n_parameters = self.n_hidden_parameters + y.shape[1] * (n_hidden + 1)
        self.tie = np.arange(n_parameters) if tie is None else np.asarray(tie)
        self.n_free_hidden = int(self.tie[: self.n_hidden_parameters].max()) + 1
        # The neurons that carry the free parameters: of tied ones the last.
        bias_index = self.tie[: self.n_hidden_parameters].reshape(self.shapes[0])[:, -1]
        self.neurons = np.array(list({index: neuron for neuron, index in enumerate(bias_index)}.values()))
        # T, or None where nothing is tied: the products with it would cost as much as all the rest.
        self.is_tied = not np.array_equal(self.tie, np.arange(n_parameters))
        self.spread = np.eye(int(self.tie.max()) + 1)[self.tie] if self.is_tied else None
        # Kept from step to step: allocating it anew would cost as much as filling it.
        n_columns = self.n_hidden_parameters + n_hidden + 1
        self._rows = np.empty((len(x), n_columns), dtype=np.float32 if n_columns >= _SINGLE_FROM else np.float64)
        # Its columns go by input, then neuron: long loops are fast; parameters go by neuron, then input.
        by_neuron = np.arange(self.n_hidden_parameters).reshape(-1, n_hidden).T.ravel()
        by_neuron = np.r_[by_neuron, np.arange(self.n_hidden_parameters, self._rows.shape[1])]
        self._by_neuron = np.ix_(by_neuron, by_neuron)
        self.ridge = ridge * len(x) * np.tile(np.arange(n_hidden + 1) < n_hidden, y.shape[1])

    def at(self, free_hidden: np.ndarray) -> Point:
        """The point with these hidden parameters and the output layer that suits them best."""
        hidden = free_hidden[self.tie[: self.n_hidden_parameters]].reshape(self.shapes[0])
        sums = self.inputs @ hidden.T
        act = np.c_[self.activation.value(sums), np.ones(len(sums))]
        output = self._best_output(act)
        error = self.y - act @ output.T
        cost = (np.sum(error**2) + np.sum(self.ridge * output.ravel() ** 2)) / error.size
        return Point(hidden, output, sums, act, error, cost)

    def _best_output(self, act: np.ndarray) -> np.ndarray:
        """The output layer [V b_o] of the least cost for act (N, h+1)."""
        gram, right = act.T @ act, self.y.T @ act
        if not self.is_tied:  # then every output has the same normal equations
            return np.linalg.solve(gram + np.diag(self.ridge[: len(gram)]), right.T).T
        spread = self.spread[self.n_hidden_parameters :, self.n_free_hidden :]
        normal = spread.T @ (np.kron(np.eye(len(right)), gram) + np.diag(self.ridge)) @ spread
        return (spread @ np.linalg.solve(normal, spread.T @ right.ravel())).reshape(self.shapes[1])

    def normal_equations(self, point: Point) -> tuple[np.ndarray, np.ndarray]:
        """J^T J (with the ridge) and J^T e over the free parameters, J = d(V act(W x + b_H) + b_o)/dp."""
        gram, n, v = self._gram(point), self.n_hidden_parameters, self._output_by_parameter(point)
        cross = np.hstack([v_k[:, None] * gram[:n, n:] for v_k in v])
        outer = np.kron(np.eye(len(v)), gram[n:, n:]) + np.diag(self.ridge)
        normal = np.block([[v.T @ v * gram[:n, :n], cross], [cross.T, outer]])
        by_output = (point.error.T @ point.act).ravel() - self.ridge * point.output.ravel()
        rhs = np.concatenate([self._descent(point), by_output])
        if not self.is_tied:
            return normal, rhs
        return self.spread.T @ normal @ self.spread, self.spread.T @ rhs

    def reduced_equations(self, point: Point) -> tuple[np.ndarray, np.ndarray]:
        """The normal equations over the free hidden parameters alone, as the output layer of point is the best one."""
        if self.is_tied:
            normal, rhs = self.normal_equations(point)
            n = self.n_free_hidden
            return normal[:n, :n] - normal[:n, n:] @ np.linalg.solve(normal[n:, n:], normal[n:, :n]), rhs[:n]
        gram, n, v = self._gram(point), self.n_hidden_parameters, self._output_by_parameter(point)
        own = gram[n:, n:] + np.diag(self.ridge[: len(gram) - n])
        left = gram[:n, :n] - gram[:n, n:] @ np.linalg.solve(own, gram[n:, :n])
        return v.T @ v * left, self._descent(point)

    def _gram(self, point: Point) -> np.ndarray:
        """B^T B, hidden parameters by neuron."""
        (n_hidden, n_in), b = self.shapes[0], self._rows
        slope, inputs = (values.astype(b.dtype, copy=False) for values in (self._slope(point), self.inputs))
        for a in range(n_in):
            np.multiply(slope, inputs[:, a : a + 1], out=b[:, a * n_hidden : (a + 1) * n_hidden])
        b[:, self.n_hidden_parameters :] = point.act
        return (b.T @ b)[self._by_neuron].astype(np.float64, copy=False)

    def _slope(self, point: Point) -> np.ndarray:
        return self.activation.slope(point.sums)

    def _output_by_parameter(self, point: Point) -> np.ndarray:
        """V, a column for each hidden parameter."""
        return np.repeat(point.output[:, :-1], self.shapes[0][1], axis=1)

    def _descent(self, point: Point) -> np.ndarray:
        """J^T e over the hidden parameters."""
        return (((point.error @ point.output[:, :-1]) * self._slope(point)).T @ self.inputs).ravel()


def levenberg_marquardt(problem: Problem, hidden: np.ndarray, stop: Stop = Stop()) -> Trained:
    """Train from hidden parameters [W b_H] (h, n+1); the output layer needs no start.

    Tied parameters start from the last neuron that they belong to. Raises numpy.linalg.LinAlgError when the output
    layer is undetermined (two equal neurons and no ridge).
    """
    free = np.empty(problem.n_free_hidden)
    free[problem.tie[: problem.n_hidden_parameters]] = hidden.ravel()
    point, mu, costs, reason = problem.at(free), MU_START, [], "steps"
    while True:
        normal, rhs = problem.reduced_equations(point)
        gradient = 2.0 * float(np.linalg.norm(rhs)) / point.error.size
        if gradient < stop.gradient:
            reason = "gradient"
        elif len(costs) > stop.stall_steps and costs[-stop.stall_steps - 1] < point.cost * (1.0 + stop.stall):
            reason = "stall"
        if reason != "steps" or len(costs) == stop.steps:
            break
        step, mu = _step(problem, free, point, normal, rhs, mu)
        if step is None:
            reason = "damping"
            break
        free, point = step
        costs.append(point.cost)
        mu = max(mu * MU_FALL, MU_MIN)
    mse = float(np.mean(point.error**2))
    return Trained(point.hidden, point.output, mse, float(point.cost), gradient, len(costs), reason)


def _step(problem, free, point, normal, rhs, mu):
    """The least damped step that lowers the cost, as ((parameters, point) or None, mu)."""
    while mu < MU_MAX:
        try:
            trial = free + cho_solve(cho_factor(normal + mu * np.eye(len(free))), rhs)
            trial_point = problem.at(trial)
        except LinAlgError:
            trial_point = None  # not positive definite in finite precision: damp more
        if trial_point is not None and trial_point.cost < point.cost:
            return (trial, trial_point), mu
        mu *= MU_RISE
    return None, mu
