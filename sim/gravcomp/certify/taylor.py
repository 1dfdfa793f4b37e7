"""Taylor models of order 2: a polynomial in the coordinates of a box, and a radius that holds all that is left.

A quantity over the box c + h t, t in [-1, 1]^n, is p(t) + [-radius, radius] with p of degree 2. Linear operations add
nothing to the radius, others what a product or a Taylor series has beyond degree 2: it shrinks with the third power of
the box. Formulas that take any number type take these models, in NumPy's arrays of objects; each model holds a batch
of boxes at once.

Rounding is outward without a change of the processor's mode. Each operation computes its coefficients by at most 16
roundings each, every one at most the unit roundoff 2^-53 times a sum of products that the product of the operands'
norms bounds: that bound goes into the radius. A radius is itself a sum of some ten positive products, so its own
rounding is below the factor of ``_up``. Sine and cosine of the processor's library are taken to be right to 4 ulp.
A model that is not bounded (a division by zero inside the box) has a radius that is infinite or no number.

Source: Makino, Berz, Taylor models and other validated functional inclusion methods (2003).
"""

from functools import cached_property, lru_cache
from numbers import Real

import numpy as np

ROUNDOFF = 2.0**-53
# Roundings of one coefficient, and those of the constants that enter it, with room to spare.
_ROUNDINGS = 16 * ROUNDOFF


@lru_cache
def pairs(n_variables: int) -> tuple[np.ndarray, np.ndarray]:
    """Variables (i, j), i <= j, of the terms of degree 2, in the order of their coefficients."""
    return np.triu_indices(n_variables)


def _up(radius: np.ndarray) -> np.ndarray:
    """At least what the exact sum and products would have given, underflow included."""
    return radius * (1.0 + 2.0**-40) + 1e-290


class Taylor:
    """Coefficients (1 + n + n (n + 1) / 2, ...) of 1, t_i and t_i t_j over batches of boxes, and a radius (...)."""

    def __init__(self, n_variables: int, coefficients: np.ndarray, radius: np.ndarray):
        self.n, self.c, self.radius = n_variables, coefficients, radius

    @classmethod
    def variables(cls, low: np.ndarray, high: np.ndarray) -> list["Taylor"]:
        """The coordinates of boxes, low and high (n, ...): one model each, that holds the whole edge."""
        n = len(low)
        centre, half = (low + high) / 2, (high - low) / 2
        models = []
        for k in range(n):
            c = np.zeros((1 + n + len(pairs(n)[0]), *low.shape[1:]))
            c[0], c[1 + k] = centre[k], half[k]
            models.append(cls(n, c, _up(_ROUNDINGS * (np.abs(low[k]) + np.abs(high[k])))))
        return models

    @property
    def constant(self) -> np.ndarray:
        return self.c[0]

    @property
    def linear(self) -> np.ndarray:
        return self.c[1 : 1 + self.n]

    @property
    def quadratic(self) -> np.ndarray:
        return self.c[1 + self.n :]

    @cached_property
    def _sizes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What the terms of degree 0, 1 and 2 can come to."""
        return np.abs(self.constant), np.abs(self.linear).sum(axis=0), np.abs(self.quadratic).sum(axis=0)

    @property
    def norm(self) -> np.ndarray:
        """What the polynomial can come to, (...)."""
        return sum(self._sizes)

    @property
    def reach(self) -> np.ndarray:
        """How far the quantity can be from its constant term, (...)."""
        return _up(self._sizes[1] + self._sizes[2] + self.radius)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest value over each box, (...): exact in each variable alone, mixed terms at their size."""
        i, j = pairs(self.n)
        slope, bend = self.linear, self.quadratic[i == j]
        # The vertex of slope t + bend t^2 where it is inside; otherwise an end.
        is_inside = np.abs(slope) < 2 * np.abs(bend)
        vertex = slope**2 / (4 * np.where(is_inside, np.abs(bend), 1.0))
        most = np.where(is_inside & (bend < 0), vertex, bend + np.abs(slope)).sum(axis=0)
        least = np.where(is_inside & (bend > 0), -vertex, bend - np.abs(slope)).sum(axis=0)
        spare = _up(np.abs(self.quadratic[i != j]).sum(axis=0) + self.radius + 4 * self.n * _ROUNDINGS * self.norm)
        return self.constant + least - spare, self.constant + most + spare

    def _with(self, coefficients: np.ndarray, radius: np.ndarray) -> "Taylor":
        return Taylor(self.n, coefficients, _up(radius))

    def __neg__(self) -> "Taylor":
        return Taylor(self.n, -self.c, self.radius)

    def __add__(self, other) -> "Taylor":
        if isinstance(other, Taylor):
            result = self._with(self.c + other.c, self.radius + other.radius)
        elif not isinstance(other, Real):
            return NotImplemented
        elif other == 0:
            return self
        else:
            result = self._with(self.c.copy(), self.radius)
            result.c[0] += other
        result.radius = _up(result.radius + _ROUNDINGS * result.norm)
        return result

    def __sub__(self, other) -> "Taylor":
        return self + -other

    def __rsub__(self, other) -> "Taylor":
        return -self + other

    def __mul__(self, other):
        if isinstance(other, Taylor):
            return self.square() if other is self else self._product(other)
        if not isinstance(other, Real):
            return NotImplemented
        if other == 0:
            return 0.0
        if abs(other) == 1:
            return self if other == 1 else -self
        size = abs(other)
        return self._with(self.c * other, self.radius * size + _ROUNDINGS * self.norm * size)

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other) -> "Taylor":
        return self * (other.reciprocal if isinstance(other, Taylor) else 1.0 / other)

    def __rtruediv__(self, other) -> "Taylor":
        return self.reciprocal * other

    def _product(self, other: "Taylor") -> "Taylor":
        n, (i, j) = self.n, pairs(self.n)
        c = self.constant * other.c
        c[1:] += other.constant * self.c[1:]
        a, b = self.linear, other.linear
        mixed = a[i] * b[j]
        mixed[i != j] += (a[j] * b[i])[i != j]
        c[1 + n :] += mixed
        (_, a1, a2), (_, b1, b2) = self._sizes, other._sizes
        beyond = a1 * b2 + a2 * (b1 + b2)
        carried = self.norm * other.radius + self.radius * (other.norm + other.radius)
        return self._with(c, beyond + carried + _ROUNDINGS * self.norm * other.norm)

    def square(self) -> "Taylor":
        n, (i, j) = self.n, pairs(self.n)
        c = (2 * self.constant) * self.c
        c[0] = self.constant**2
        a = self.linear
        c[1 + n :] += a[i] * a[j] * np.where(i == j, 1.0, 2.0).reshape(-1, *(1,) * (a.ndim - 1))
        _, a1, a2 = self._sizes
        beyond = a2 * (2 * a1 + a2)
        return self._with(c, beyond + self.radius * (2 * self.norm + self.radius) + _ROUNDINGS * self.norm**2)

    def _series(self, f0, f1, f2, remainder, size) -> "Taylor":
        """f0 + f1 d + f2 d^2 of the distance d from the constant term.

        remainder: what the function has beyond. size: of f0, for the rounding of f0, f1 and f2.
        """
        away = Taylor(self.n, self.c.copy(), self.radius)
        away.c[0] = 0.0
        squared = away.square()
        c = f1 * away.c + f2 * squared.c
        c[0] += f0
        rounding = _ROUNDINGS * (size + np.abs(f1) * self.reach + np.abs(f2) * self.reach**2)
        return self._with(c, np.abs(f1) * away.radius + np.abs(f2) * squared.radius + remainder + rounding)

    @cached_property
    def reciprocal(self) -> "Taylor":
        """1/x: 1/c - d/c^2 + d^2/c^3 - d^3/(c^3 (c + d))."""
        c, reach = self.constant, self.reach
        least = np.abs(c) - reach
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            remainder = np.where(least > 0, reach**3 / (np.abs(c) ** 3 * least), np.inf)
            return self._series(1 / c, -1 / c**2, 1 / c**3, remainder, np.abs(1 / c))

    def sqrt(self) -> "Taylor":
        """Square root; its third derivative is 3/8 x^(-5/2), largest at the least x."""
        c, reach = self.constant, self.reach
        least = c - reach
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            remainder = np.where(least > 0, reach**3 / (16 * least**2.5), np.inf)
            root = np.sqrt(c)
            return self._series(root, 1 / (2 * root), -1 / (8 * root**3), remainder, root)

    def sin(self) -> "Taylor":
        sine, cosine = np.sin(self.constant), np.cos(self.constant)
        return self._series(sine, cosine, -sine / 2, self.reach**3 / 6, 1.0)

    def cos(self) -> "Taylor":
        sine, cosine = np.sin(self.constant), np.cos(self.constant)
        return self._series(cosine, -sine, -cosine / 2, self.reach**3 / 6, 1.0)
