"""Training for the largest error: its cost and slopes, the boundary of workspaces, what it reaches."""

import numpy as np
import pytest

from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp.robot.spheiro.kinematics import direct_kinematics
from gravcomp.training import largest_error as module
from gravcomp.training.largest_error import Cost, PoseRows, Weights, descend, edge_and_inside, least_largest_error
from gravcomp.training.training import Effort, train, workspace_set
from machines import MACHINE, SHIPPED, P
from mechanisms import WEIGHTS

COST = Cost(10, 0.8)


@pytest.fixture
def problem():
    """Ten neurons without training, of two inputs and two outputs; the last rows are worst poses."""
    rng = np.random.default_rng(4)
    x, y = np.c_[rng.uniform(-1, 1, (60, 2)), np.ones(60)], rng.uniform(-0.2, 0.2, (60, 2))
    poses = PoseRows(x, y, np.array([1.0, 2.0]), 40)
    return poses, Weights(0.5 * rng.standard_normal((10, 3)), 0.1 * rng.standard_normal((2, 11)))


def test_cost_is_that_of_the_formula(problem):
    poses, weights = problem
    error = poses.errors(weights)
    square = np.mean(error[:40] ** 2) / 0.2**2
    assert poses.cost(error, COST) == pytest.approx(square + np.sum(np.abs(error / 0.6) ** 10) / 80)


def test_descent_is_minus_the_derivative_of_the_cost(problem):
    poses, weights = problem
    _, descent = poses.normal_equations(weights, poses.errors(weights), COST)
    steps = 1e-6 * np.eye(len(descent))

    def value(step):
        return poses.cost(poses.errors(weights.moved(step)), COST)

    slopes = [(value(step) - value(-step)) / 2e-6 for step in steps]
    np.testing.assert_allclose(descent, -np.array(slopes), rtol=1e-4, atol=1e-6 * np.abs(descent).max())


def test_steps_go_down_and_may_leave_the_hidden_layer_alone(problem):
    poses, weights = problem
    before = poses.cost(poses.errors(weights), COST)
    found, after = descend(poses, weights, COST, 5)
    assert after < 0.9 * before
    assert after == pytest.approx(poses.cost(poses.errors(found), COST))
    outer, _ = descend(poses, weights, COST, 5, output_only=True)
    np.testing.assert_array_equal(outer.hidden, weights.hidden)
    assert not np.array_equal(outer.output, weights.output)


def test_boundary_of_the_cone_is_its_largest_tilt_and_torsion():
    q = MACHINE.robot.boundary(200, 1)
    rotation, axis = direct_kinematics(q, P), np.ones(3) / np.sqrt(3)
    tilt = np.rad2deg(np.arccos(np.clip(np.einsum("i,nij,j->n", axis, rotation, axis), -1, 1)))
    is_side = tilt > P.tilt_max_deg - 1e-6
    assert 100 < is_side.sum() < 165  # two thirds
    assert tilt.max() < P.tilt_max_deg + 1e-6
    # About n, of what is left when the tilt is taken away: the angle of R is that of both where the tilt is 0.
    trace = np.trace(rotation[~is_side], axis1=1, axis2=2)
    half = np.cos(np.deg2rad(tilt[~is_side]) / 2) * np.cos(np.deg2rad(P.torsion_max_deg) / 2)
    np.testing.assert_allclose(trace, 4 * half**2 - 1, atol=1e-9)


def test_boundary_of_a_box_has_an_axis_at_its_end():
    robot = load_machine(WEIGHTS / "arm2").robot
    low, high = robot.ranges
    q = robot.boundary(100, 2)
    at_end = (q == low) | (q == high)
    assert (at_end.sum(axis=1) >= 1).all()
    assert at_end.any(axis=0).all()
    assert ((q >= low) & (q <= high)).all()


def test_largest_error_falls_and_weights_stay_on_the_grid(monkeypatch):
    monkeypatch.setattr(module, "_POOL", 1500)
    monkeypatch.setattr(module, "_ROUNDS", 2)
    data = workspace_set(300, MACHINE.robot, 1)
    effort = Effort(draws=4, tied_hops=4, hops=4, search_poses=200)
    network, _ = train(data, MACHINE, n_hidden=12, n_starts=1, seed=1, backend="threading", effort=effort)
    q = edge_and_inside(MACHINE.robot, 4000, 77)

    def worst(found):
        return np.abs(found.forces(q) - MACHINE.robot.forces(q)).max()

    wanted = 0.5 * worst(network)
    found = least_largest_error(
        network, MACHINE.robot, MACHINE.drive, wanted=wanted, norm=12, n_poses=300, hops=2, seed=1
    )
    print(f"largest error {worst(network):.2f} -> {worst(found):.2f} N")
    assert worst(found) < 0.7 * worst(network)
    grid = 2.0**-15
    np.testing.assert_allclose(found.hidden_weights / grid, np.rint(found.hidden_weights / grid), atol=1e-9)


def test_worst_poses_are_sought_among_others_every_time(monkeypatch):
    monkeypatch.setattr(module, "_POOL", 500)
    network = load_network(SHIPPED)
    search = module._Search(network, MACHINE.robot, 100, 1)
    weights = Weights(
        np.c_[network.hidden_weights, network.hidden_bias], np.c_[network.output_weights, network.output_bias]
    )
    for _ in range(2):
        search.add_worst(weights, 50)
    added = search.poses.x[100:]
    assert len(np.unique(added, axis=0)) == 100
    largest = np.abs(search.poses.errors(weights)).max(axis=1)
    assert largest[100:].min() > np.median(largest[:100])


def test_shipped_network_errs_by_less_than_asked_and_the_default_stays_the_least_square():
    default, least = (load_network(SHIPPED.parent / name) for name in ("spheiro", "spheiro_minimax"))
    inside, edge = MACHINE.robot.workspace(200_000, 501), MACHINE.robot.boundary(200_000, 502)
    squares, largest = [], []
    for network in (default, least):
        errors = [network.forces(q) - MACHINE.robot.forces(q) for q in (inside, edge)]
        squares.append(np.mean(errors[0] ** 2))
        largest.append(max(np.abs(error).max() for error in errors))
    print(f"mean square {squares} N^2, largest {largest} N")
    assert least.n_hidden == 20
    assert largest[1] <= 0.28
    assert squares[1] <= 0.0055
    assert squares[0] < squares[1]
