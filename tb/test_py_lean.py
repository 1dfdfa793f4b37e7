"""The lean form of the network: as accurate as today's core, free of overflow, its vertex form exact."""

import numpy as np
import pytest

from gravcomp.core import formats as q
from gravcomp.core.formats import quantise
from gravcomp.network.activation import gamma
from gravcomp.network.weights import load_network
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.workspace import pose
from gravcomp.twin import lean
from gravcomp.twin.lean import LeanNetwork, lean_network
from machines import MACHINE, SHIPPED, P

SEED, N_ORDERS, N_POSES = 1, 60, 20000
DRIVE = MACHINE.drive


def fitted_at() -> np.ndarray:
    """Poses of the workspace and, as many again, near its edge, where errors are largest."""
    rng = np.random.default_rng(SEED)
    tilt, torsion = np.deg2rad([P.tilt_max_deg, P.torsion_max_deg])
    edge = pose(
        rng.uniform(0, 2 * np.pi, 20000), tilt * rng.uniform(0.9, 1, 20000), torsion * rng.uniform(-1, 1, 20000)
    )
    return np.concatenate([MACHINE.robot.workspace(20000, SEED), inverse_kinematics(edge, P)])


@pytest.fixture(scope="module")
def network():
    return load_network(SHIPPED)


@pytest.fixture(scope="module")
def form(network) -> LeanNetwork:
    return lean_network(network, quantise(network, DRIVE), DRIVE, fitted_at(), N_ORDERS, SEED)


@pytest.mark.parametrize("seed", [41, 51, 61])  # 41: the poses of `gravcomp formats`; 7.4 to 9.3 mN at most
def test_it_is_as_accurate_as_the_core_on_poses_that_no_fit_saw(form, network, seed):
    position = MACHINE.robot.workspace(N_POSES, seed)
    error = lean.core(DRIVE.counts(position), form) - 1000.0 * network.forces(position)
    assert np.sqrt((error**2).mean()) <= 1.8
    assert np.abs(error).max() <= 6 * 1.8  # 60 000 values, each a sum of many truncations, stay within six deviations


def test_weights_are_operands_and_sums_are_narrow(form):
    for codes in (form.hidden_weights, form.output_weights):
        assert np.abs(codes).max() < 2 ** (q.OPERAND_BITS - 1)
    assert form.sum_bits[0] <= 28
    assert form.sum_bits[1] <= 29


def test_no_partial_sum_leaves_its_width(form):
    rng = np.random.default_rng(SEED)
    counts = np.concatenate([rng.integers(-200000, 200000, (5000, 3)), 2**31 - 1 - np.zeros((1, 3), np.int64)])
    code = np.clip(counts, form.count_low, form.count_high) >> form.count_shift
    hidden = code[:, None, :] * form.hidden_weights >> form.hidden_shift
    output = lean.signed_gamma(counts, form)[:, None, :] * form.output_weights >> form.output_shift
    for bits, bias, products in zip(form.sum_bits, (form.hidden_bias, form.output_bias), (hidden, output), strict=True):
        order = rng.permutation(products.shape[-1])
        partial = bias[:, None] + np.cumsum(products[..., order], axis=-1)
        assert max(np.abs(partial).max(), np.abs(np.cumsum(products, axis=-1)).max()) < 2 ** (bits - 1)


def test_vertex_form_is_gamma_at_every_code():
    """One neuron whose sum is the count itself: all codes of a, and beyond."""
    code = np.arange(-(2**18), 2**18)
    one = np.ones((1, 1), np.int64)
    zero, ends = np.zeros(1, np.int64), np.array([2**18])
    bare = LeanNetwork(-ends, ends, zero, one, zero, q.PREACTIVATION_FRACTION, one, zero, 0)
    h = np.ldexp(lean.signed_gamma(code[:, None], bare)[:, 0].astype(float), -q.HIDDEN_FRACTION)
    a = np.ldexp(code + 0.5, -q.PREACTIVATION_FRACTION)  # the middle of what a code stands for
    # Half an LSB of a is one of h, through a slope of at most 1; the truncation of the square is below one more.
    assert np.abs(h - gamma(a)).max() < 2.0 * 2.0**-q.HIDDEN_FRACTION
    np.testing.assert_array_equal(h[a > 2.0], 1.0)
    np.testing.assert_array_equal(h[a < -2.0], -1.0)
