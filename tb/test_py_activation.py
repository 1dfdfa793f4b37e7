"""Gamma: values and slope at its knots, and against its equation."""

import numpy as np
import pytest

from gravcomp.network.activation import BETA, LIMIT, THETA, gamma, gamma_slope


@pytest.mark.parametrize(
    ("x", "value", "slope"),
    [(-9.0, -1.0, 0.0), (-2.0, -1.0, 0.0), (-1.0, -0.75, 0.5), (0.0, 0.0, 1.0), (1.0, 0.75, 0.5), (2.0, 1.0, 0.0)],
)
def test_gamma_has_its_values_and_slopes_at_the_knots(x, value, slope):
    assert gamma(np.array(x)) == value
    assert gamma_slope(np.array(x)) == slope


def test_gamma_equals_its_equation_on_both_sides_of_zero():
    x = np.linspace(0.0, LIMIT, 101)
    np.testing.assert_allclose(gamma(x), x * (BETA - THETA * x), rtol=0, atol=1e-15)
    np.testing.assert_allclose(gamma(-x), -x * (BETA + THETA * -x), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(gamma(np.array([-50.0, 50.0])), [-1.0, 1.0])


def test_gamma_slope_is_its_derivative():
    x = np.linspace(-2.5, 2.5, 1000)  # no sample within a step of a knot, where the second derivative jumps
    step = 1e-6
    difference = (gamma(x + step) - gamma(x - step)) / (2 * step)
    np.testing.assert_allclose(gamma_slope(x), difference, rtol=0, atol=1e-9)


def test_gamma_differs_from_tanh_by_at_most_0_0433():
    x = np.linspace(-6.0, 6.0, 10_001)
    assert np.abs(gamma(x) - np.tanh(x)).max() == pytest.approx(0.0432, abs=1e-4)
