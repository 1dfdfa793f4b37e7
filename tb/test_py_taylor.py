"""Taylor models hold what they stand for: every operation at points of its boxes, against wider arithmetic.

The truth is computed in the 64-bit mantissas of long double, or in fractions; both are far below the radii, that hold
roundings of 53 bits.
"""

from fractions import Fraction

import numpy as np
import pytest

from gravcomp.certify import taylor
from gravcomp.certify.taylor import Taylor, pairs

SEED, N_BOXES, N_POINTS = 3, 100, 20
WIDE = np.longdouble


def boxes(size: float, n: int = 3):
    """Variables of boxes of that half side around 1 to 3, and points t (n, N_POINTS, N_BOXES) in them, corners too."""
    rng = np.random.default_rng(SEED)
    centre = rng.uniform(1.0, 3.0, (n, N_BOXES))
    half = size * rng.uniform(0.1, 1.0, centre.shape)
    t = rng.uniform(-1.0, 1.0, (n, N_POINTS, N_BOXES))
    t[:, : N_POINTS // 2] = np.sign(t[:, : N_POINTS // 2])
    low, high = centre - half, centre + half
    # The real coordinates of the points, within what the variables say that they hold.
    t, least, most = t.astype(WIDE), low.astype(WIDE)[:, None], high.astype(WIDE)[:, None]
    return Taylor.variables(low, high), t, np.clip((least + most) / 2 + t * (most - least) / 2, least, most)


def value(model: Taylor, t: np.ndarray) -> np.ndarray:
    """The polynomial at points t."""
    i, j = pairs(model.n)
    c = model.c.astype(WIDE)
    terms = [c[0], *(c[1 + k] * t[k] for k in range(model.n))]
    return sum(terms) + sum(c[1 + model.n + k] * t[a] * t[b] for k, (a, b) in enumerate(zip(i, j, strict=True)))


OPERATIONS = {
    "sum": lambda x, y, z: x + y + 0.1 - z,
    "product": lambda x, y, z: x * y * z,
    "square": lambda x, y, z: (s := x + y - 0.3 * z) * s,
    "scalar": lambda x, y, z: 0.1 * x - y * 0.3,
    "quotient": lambda x, y, z: x / (y + z * z),
    "root": lambda x, y, z: np.sqrt(x * y + z),
    "sine": lambda x, y, z: np.sin(1.7 * x - y),
    "cosine": lambda x, y, z: np.cos(x * y),
    "mixed": lambda x, y, z: np.sin(x) * np.cos(y) / np.sqrt(x * x + z * z) - x * y / z,
}


def outside(name: str, size: float) -> int:
    """Points at which an operation leaves its model, or the bounds of it."""
    models, t, at = boxes(size)
    model, truth = OPERATIONS[name](*np.array(models, dtype=object)[:, None])[0], OPERATIONS[name](*at)
    low, high = model.bounds()
    return int(((np.abs(value(model, t) - truth) > model.radius) | (truth < low) | (truth > high)).sum())


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-3, 0.3])
@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_stays_in_its_model(name, size):
    assert outside(name, size) == 0


def test_rounding_is_outward_to_the_last_bit():
    """A sum of products of thirds in fractions: no number of 53 bits is right, the model holds the right one."""
    rng = np.random.default_rng(SEED)
    a, b = rng.uniform(-1.0, 1.0, (2, 200)) / 3
    point = Taylor.variables(np.stack([a, b]), np.stack([a, b]))
    model = point[0] * point[1] + point[0] * 0.1 - point[1]
    for k in range(200):
        x, y = Fraction(a[k]), Fraction(b[k])
        truth = x * y + x * Fraction(0.1) - y
        assert abs(truth - Fraction(model.constant[k])) <= Fraction(model.radius[k])
        assert model.radius[k] < 1e-14


@pytest.mark.parametrize("operation", ["quotient", "root", "sine", "product"])
def test_what_is_left_shrinks_with_the_third_power_of_the_box(operation):
    radius = [
        OPERATIONS[operation](*np.array(boxes(size)[0], dtype=object)[:, None])[0].radius for size in (0.02, 0.01)
    ]
    assert np.median(radius[0] / radius[1]) == pytest.approx(8.0, rel=0.1)


@pytest.mark.parametrize("operation", ["quotient", "root"])
def test_a_function_without_a_bound_says_so(operation):
    x, y = Taylor.variables(np.full((2, 1), -1.0), np.full((2, 1), 2.0))
    with np.errstate(all="ignore"):
        low, high = (x / y if operation == "quotient" else y.sqrt()).bounds()
    assert not np.isfinite(high - low).any()


def test_bounds_of_a_polynomial_are_those_of_a_fine_grid():
    (x, y), _, _ = boxes(0.5, n=2)
    x, y = x - 2.0, y - 2.0
    low, high = (x * x - 0.3 * x + 0.5 * (y - y * y)).bounds()
    t = np.stack(np.meshgrid(*[np.linspace(-1, 1, 201)] * 2)).reshape(2, -1, 1)
    at = value(x * x - 0.3 * x + 0.5 * (y - y * y), t)
    np.testing.assert_allclose(
        np.stack([low, high]), np.stack([at.min(axis=0), at.max(axis=0)]).astype(float), atol=1e-4
    )


def without_beyond(self, other):
    exact = original_product(self, other)
    (_, a1, a2), (_, b1, b2) = self._sizes, other._sizes
    return Taylor(exact.n, exact.c, exact.radius - (a1 * b2 + a2 * (b1 + b2)))


def with_mixed_terms_once(self):
    exact = original_product(self, self)
    i, j = pairs(self.n)
    exact.quadratic[i != j] -= (self.linear[i] * self.linear[j])[i != j]
    return exact


original_product, original_series = Taylor._product, Taylor._series
UNSOUND = {  # what is wrong, the operation that must show it, the size of the boxes
    "a product forgets degrees 3 and 4": ("_product", without_beyond, "product", 0.3),
    "a series forgets its remainder": (
        "_series",
        lambda self, f0, f1, f2, _, size: original_series(self, f0, f1, f2, 0.0, size),
        "quotient",
        0.3,
    ),
    "a square takes mixed terms once": ("square", with_mixed_terms_once, "square", 0.3),
}


@pytest.mark.parametrize("name", UNSOUND)
def test_an_unsound_rule_is_caught(name, monkeypatch):
    rule, wrong, operation, size = UNSOUND[name]
    monkeypatch.setattr(Taylor, rule, wrong)
    assert outside(operation, size) > 0


@pytest.mark.parametrize("operation", ["sum", "product", "quotient", "root", "sine"])
def test_rounding_that_is_forgotten_is_caught(operation, monkeypatch):
    monkeypatch.setattr(taylor, "_ROUNDINGS", 0.0)
    assert outside(operation, 0.0) > 0
