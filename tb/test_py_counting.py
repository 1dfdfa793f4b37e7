"""Operation counts: every operation counts once, structural zeros are free, the budgets come out."""

import numpy as np
import pytest

from gravcomp.network.weights import Network, load_network
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.statics import holding_forces_at
from gravcomp.robot.spheiro.workspace import sample_workspace
from gravcomp_lab.paper.operations import (
    Counted,
    OperationCount,
    count_network_operations,
    count_statics_operations,
    counted,
    n_ary_sum,
    network_on_counted,
    statics_on_counted,
)
from machines import P
from runner import ROOT


def random_network(n_axes, n_hidden, seed=0, gain=1.0):
    rng = np.random.default_rng(seed)
    return Network(
        gain * rng.normal(size=(n_hidden, n_axes)),
        rng.normal(size=n_hidden),
        rng.normal(size=(n_axes, n_hidden)),
        rng.normal(size=n_axes),
        0.01 * rng.normal(size=n_axes),
        6.0 + rng.uniform(size=n_axes),
        50.0 + rng.normal(size=n_axes),
        40.0 + rng.normal(size=n_axes),
        ("m",) * n_axes,
    )


@pytest.mark.parametrize(
    ("operation", "kind", "value"),
    [
        (lambda a, b: a * b, "multiplications", 6.0),
        (lambda a, b: 2.5 * a, "multiplications", 5.0),
        (lambda a, b: a + b, "sums", 5.0),
        (lambda a, b: 1.0 - a, "sums", -1.0),
        (lambda a, b: a - 1, "sums", 1.0),
        (lambda a, b: n_ary_sum([a, 1.0, b, a]), "sums", 8.0),
        (lambda a, b: b / a, "divisions", 1.5),
        (lambda a, b: 1 / a, "divisions", 0.5),
        (lambda a, b: np.sqrt(a * 1 + 0), "square_roots", np.sqrt(2.0)),
        (lambda a, b: np.sin(a), "trigonometric", np.sin(2.0)),
        (lambda a, b: np.arctan2(np.array([a]), np.array([b]))[0], "trigonometric", np.arctan2(2.0, 3.0)),
    ],
)
def test_operation_counts_once_and_gives_its_value(operation, kind, value):
    count = OperationCount()
    result = operation(Counted(2.0, count), Counted(3.0, count))
    assert float(result) == pytest.approx(value, rel=1e-15)
    assert count == OperationCount(**{kind: 1})
    assert count.total == 1


def test_structural_zeros_ones_and_choices_are_free():
    count = OperationCount()
    a = Counted(2.0, count)
    results = [a * 1, -1.0 * a, a * 0, a + 0.0, 0 - a, a - 0.0, -a, abs(a), np.clip(a, -1, 1), a / 1.0, 0.0 / a]
    assert [float(r) for r in results] == [2.0, -2.0, 0.0, 2.0, -2.0, 2.0, -2.0, 2.0, 1.0, 2.0, 0.0]
    assert a > 1
    assert n_ary_sum([1.0, 2.0]) == 3.0
    assert count.total == 0


def test_a_computed_zero_or_one_is_not_free():
    count = OperationCount()
    a, one = Counted(2.0, count), Counted(1.0, count)
    _ = a * one, a + Counted(0.0, count)
    assert count == OperationCount(multiplications=1, sums=1)


def test_ordinary_array_code_counts_every_element():
    count = OperationCount()
    a, b = counted(np.arange(1.0, 7.0).reshape(2, 3), count), np.arange(2.0, 5.0)
    np.testing.assert_array_equal(np.cross(a, b).astype(float), np.cross(np.arange(1.0, 7.0).reshape(2, 3), b))
    assert count == OperationCount(multiplications=12, sums=6)


def test_network_of_20_neurons_takes_166_multiplications_and_43_sums():
    count, apart = count_network_operations(random_network(3, 20))
    assert count == OperationCount(multiplications=166, sums=43)
    assert apart == OperationCount()


def test_network_with_sines_and_cosines_costs_the_formula_and_they_are_counted_apart():
    """p features, n neurons, m axes: p + p n + 2 n + n m + m products, 2 n + m sums. Apart per axis that turns: five
    products, four of the phase and one for radians; three sums, of the phase and for either result."""
    network = load_network(ROOT / "weights" / "ur5")
    p, n, m = 12, network.n_hidden, 6
    q = np.random.default_rng(4).uniform(-6, 6, (20, m))
    for q_rad in q:
        forces, count, apart = network_on_counted(network, q_rad)
        np.testing.assert_allclose(forces, network.forces(q_rad), rtol=0, atol=1e-3)  # first order of b
        assert count == OperationCount(multiplications=p + p * n + 2 * n + n * m + m, sums=2 * n + m)
        assert apart == OperationCount(multiplications=5 * m, sums=3 * m)


@pytest.mark.parametrize(("n_axes", "n_hidden"), [(3, 15), (3, 40), (1, 4)])
def test_network_count_grows_with_its_size(n_axes, n_hidden):
    count, _ = count_network_operations(random_network(n_axes, n_hidden))
    assert count.multiplications == 2 * n_axes + 2 * n_hidden * (n_axes + 1)
    assert count.sums == 2 * n_hidden + n_axes


@pytest.mark.parametrize("gain", [1.0, 30.0])
def test_counted_network_computes_the_networks_forces(gain):
    network = random_network(3, 20, seed=1, gain=gain)
    for q in inverse_kinematics(sample_workspace(20, P, seed=2), P):
        forces, count, _ = network_on_counted(network, q)
        np.testing.assert_allclose(forces, network.forces(q), rtol=0, atol=1e-10)
        assert (count.multiplications, count.sums) == (166, 43)


def test_counted_statics_compute_the_holding_forces_at_the_same_cost_everywhere():
    counts = []
    for q in inverse_kinematics(sample_workspace(20, P, seed=3), P):
        forces, count = statics_on_counted(q, P)
        np.testing.assert_allclose(forces, holding_forces_at(q, P), rtol=0, atol=1e-10)
        counts.append(count)
    assert all(count == counts[0] for count in counts)
    assert count_statics_operations(P) == counts[0]


def test_closed_form_statics_need_no_trigonometry_and_a_fraction_of_the_papers_8305_operations():
    count = count_statics_operations(P)
    print(f"closed-form statics: {count}, total {count.total}; the paper's model: 8305, 532 trigonometric")
    assert count.trigonometric == 0
    assert count.square_roots == 4 + 3  # quaternion, link lengths
    assert count.total < 8305 / 20
