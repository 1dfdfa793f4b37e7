"""Levenberg-Marquardt: its equations against finite differences, known networks, and SciPy's least squares."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import least_squares

from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Problem, Stop, levenberg_marquardt
from gravcomp.training.symmetry import cyclic_tie

N_IN, N_OUT = 3, 3
GAMMA, TANH = ACTIVATIONS["gamma"], ACTIVATIONS["tanh"]


def evaluate(parameters, x, n_hidden, activation):
    """y = V act(W x + b_H) + b_o, written independently of the trainer; parameters [W b_H] then [V b_o], by rows."""
    split = n_hidden * (x.shape[1] + 1)
    hidden = parameters[:split].reshape(n_hidden, -1)
    output = parameters[split:].reshape(-1, n_hidden + 1)
    return activation.value(x @ hidden[:, :-1].T + hidden[:, -1]) @ output[:, :-1].T + output[:, -1]


def finite_difference_jacobian(function, parameters, step=1e-6):
    columns = [
        (function(parameters + d).ravel() - function(parameters - d).ravel()) / (2 * step)
        for d in step * np.eye(len(parameters))
    ]
    return np.stack(columns, axis=1)


def smooth_target(x):
    return np.stack([np.sin(2 * x[:, 0]) + x[:, 1], x[:, 1] * x[:, 2], np.exp(-x[:, 2]) * x[:, 0]], axis=1)


@pytest.mark.parametrize("activation", ["gamma", "tanh"])
@pytest.mark.parametrize("is_tied", [False, True])
def test_normal_equations_equal_those_of_the_finite_difference_jacobian(activation, is_tied):
    rng = np.random.default_rng(1)
    n_hidden, x = 4, rng.uniform(-1, 1, (50, N_IN))
    y = smooth_target(x)
    n_parameters = n_hidden * (N_IN + 1) + N_OUT * (n_hidden + 1)
    # Neurons 0 and 1 share their first weight, outputs 0 and 1 their bias.
    tie = np.arange(n_parameters)
    if is_tied:
        tie[4] = tie[0]
        tie[4 + n_hidden * (N_IN + 1)] = tie[4 + n_hidden * (N_IN + 1) + n_hidden + 1]
        tie = np.unique(tie, return_inverse=True)[1]
    problem = Problem(x, y, n_hidden, ACTIVATIONS[activation], tie if is_tied else None)
    # A point away from the best output layer, so that the output's part of the gradient counts too.
    free = rng.normal(size=tie.max() + 1)
    parameters = free[tie]
    point = problem.at(free[: problem.n_free_hidden])
    error = y - evaluate(parameters, x, n_hidden, ACTIVATIONS[activation])
    point = replace(point, output=parameters[n_hidden * (N_IN + 1) :].reshape(N_OUT, -1), error=error)
    jacobian = finite_difference_jacobian(lambda z: evaluate(z[tie], x, n_hidden, ACTIVATIONS[activation]), free)
    normal, rhs = problem.normal_equations(point)
    np.testing.assert_allclose(normal, jacobian.T @ jacobian, rtol=0, atol=1e-6 * np.abs(normal).max())
    np.testing.assert_allclose(rhs, jacobian.T @ error.ravel(), rtol=0, atol=1e-6 * np.abs(rhs).max())


@pytest.mark.parametrize("tie", [None, cyclic_tie(4, 3)], ids=["free", "tied"])
def test_reduced_equations_give_the_step_of_all_parameters_with_the_hidden_ones_damped(tie):
    """Whatever the damping: their solution is the hidden part of that of the full equations."""
    rng = np.random.default_rng(5)
    x = rng.uniform(-1, 1, (60, N_IN))
    problem = Problem(x, smooth_target(x), 4, GAMMA, tie, ridge=1e-4)
    point = problem.at(rng.normal(size=problem.n_free_hidden))
    (normal, rhs), (reduced, descent) = problem.normal_equations(point), problem.reduced_equations(point)
    n = problem.n_free_hidden
    for mu in (1e-3, 10.0):
        whole = np.linalg.solve(normal + mu * np.diag(np.arange(len(rhs)) < n), rhs)
        np.testing.assert_allclose(np.linalg.solve(reduced + mu * np.eye(n), descent), whole[:n], rtol=1e-7, atol=1e-9)


def test_equations_in_single_precision_differ_by_its_rounding(monkeypatch):
    """Of many columns, where nothing but the time changes: 2^-24 of what is summed."""
    rng = np.random.default_rng(6)
    x, start = rng.uniform(-1, 1, (500, N_IN)), rng.normal(size=(90, N_IN + 1))
    single = Problem(x, smooth_target(x), 90, GAMMA)
    monkeypatch.setattr(f"{levenberg_marquardt.__module__}._SINGLE_FROM", 10**6)
    double = Problem(x, smooth_target(x), 90, GAMMA)
    (one, _), (two, _) = (problem.normal_equations(problem.at(start.ravel())) for problem in (single, double))
    assert 0 < np.abs(one - two).max() <= 500 * 2.0**-24 * np.abs(two).max()


@pytest.mark.parametrize("activation", [GAMMA, TANH])
def test_training_recovers_a_known_network(activation):
    rng = np.random.default_rng(2)
    n_hidden = 3
    teacher = rng.uniform(-1.5, 1.5, n_hidden * (N_IN + 1) + N_OUT * (n_hidden + 1))
    x, unseen = rng.uniform(-1, 1, (2, 300, N_IN))
    problem = Problem(x, evaluate(teacher, x, n_hidden, activation), n_hidden, activation)
    starts = rng.normal(size=(8, n_hidden, N_IN + 1))
    best = min((levenberg_marquardt(problem, start) for start in starts), key=lambda fit: fit.mse)
    found = np.concatenate([best.hidden.ravel(), best.output.ravel()])
    expected = evaluate(teacher, unseen, n_hidden, activation)
    np.testing.assert_allclose(evaluate(found, unseen, n_hidden, activation), expected, rtol=0, atol=1e-6)


def scipy_cost(problem, x, y, n_hidden, activation, hidden, output):
    """Cost that SciPy's own Levenberg-Marquardt (MINPACK) reaches on all parameters at once, without our Jacobian."""
    root_ridge = np.sqrt(problem.ridge)

    def residuals(p):
        return np.r_[(evaluate(p, x, n_hidden, activation) - y).ravel(), root_ridge * p[hidden.size :]]

    start = np.concatenate([hidden.ravel(), output.ravel()])
    return 2 * least_squares(residuals, start, method="lm").cost / y.size


@pytest.mark.parametrize("activation", [GAMMA, TANH])
def test_scipy_least_squares_lowers_no_minimum_that_training_found(activation):
    for seed in range(6):
        rng = np.random.default_rng(seed)
        x = rng.uniform(-1, 1, (200, N_IN))
        y = smooth_target(x)
        problem = Problem(x, y, 5, activation, ridge=1e-5)
        fit = levenberg_marquardt(problem, rng.normal(size=(5, N_IN + 1)), Stop(steps=5000, stall=1e-7))
        # The stop allows 1e-7 per 30 steps of a descent that has become linear; 1e-4 is a thousand times that.
        assert scipy_cost(problem, x, y, 5, activation, fit.hidden, fit.output) > fit.cost * (1 - 1e-4)


def test_scipy_least_squares_is_no_better_over_twenty_equal_starts():
    # Which of several minima one start falls into is chance in either algorithm; over many starts it is not.
    ratios, ours, theirs = [], [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        x = np.random.default_rng(100).uniform(-1, 1, (200, N_IN))
        y = smooth_target(x)
        start = rng.normal(size=(5, N_IN + 1))
        problem = Problem(x, y, 5, TANH, ridge=1e-5)
        ours.append(levenberg_marquardt(problem, start, Stop(steps=5000, stall=1e-7)).cost)
        theirs.append(scipy_cost(problem, x, y, 5, TANH, start, problem.at(start.ravel()).output))
        ratios.append(np.log(ours[-1] / theirs[-1]))
    print(f"best {min(ours):.3e} against {min(theirs):.3e}, mean ratio {np.exp(np.mean(ratios)):.3f}")
    assert min(ours) <= min(theirs) * (1 + 1e-4)
    assert np.mean(ratios) <= 0.0


def test_training_stops_at_the_gradient_threshold():
    rng = np.random.default_rng(3)
    x = rng.uniform(-1, 1, (200, N_IN))
    problem = Problem(x, smooth_target(x), 5, GAMMA)
    start = rng.normal(size=(5, N_IN + 1))
    fit = levenberg_marquardt(problem, start, Stop(gradient=1e-3))
    before = levenberg_marquardt(problem, start, Stop(gradient=1e-3, steps=fit.steps - 1))
    assert fit.reason == "gradient"
    assert fit.gradient < 1e-3 <= before.gradient


def test_reported_gradient_is_the_slope_of_the_mean_square_error():
    rng = np.random.default_rng(4)
    x = rng.uniform(-1, 1, (100, N_IN))
    y = smooth_target(x)
    fit = levenberg_marquardt(Problem(x, y, 4, TANH), rng.normal(size=(4, N_IN + 1)), Stop(steps=5))
    parameters = np.concatenate([fit.hidden.ravel(), fit.output.ravel()])
    slope = finite_difference_jacobian(lambda p: np.mean((evaluate(p, x, 4, TANH) - y) ** 2), parameters)
    assert fit.gradient == pytest.approx(np.linalg.norm(slope), rel=1e-5)
    assert fit.steps == 5
    assert fit.reason == "steps"


def test_cost_never_rises_and_ridge_keeps_output_weights_small():
    rng = np.random.default_rng(5)
    x = rng.uniform(-1, 1, (100, N_IN))
    start = rng.normal(size=(8, N_IN + 1))
    problem = Problem(x, smooth_target(x), 8, GAMMA, ridge=1e-4)
    costs = [levenberg_marquardt(problem, start, Stop(steps=n)).cost for n in range(12)]
    assert all(later < earlier for earlier, later in pairwise(costs))
    free = levenberg_marquardt(Problem(x, smooth_target(x), 8, GAMMA), start, Stop(steps=50))
    kept = levenberg_marquardt(problem, start, Stop(steps=50))
    assert np.abs(kept.output[:, :-1]).max() < np.abs(free.output[:, :-1]).max()
