"""Corrections without physics: a table over one measured variable, a wave in time, a smooth function of all positions.

They compete with the effects in the search, so that an effect on no list is not given a wrong name, and they say
which variable it follows. Each acts on one axis and is linear in its values.
"""

from dataclasses import dataclass
from math import comb

import numpy as np
from sklearn.preprocessing import PolynomialFeatures

from gravcomp.diagnosis.candidate import Candidate, Parameter, Variable, on_axis, variables
from gravcomp.diagnosis.search.hinge import SIDES, corner_in, corners_in, hinge
from gravcomp.diagnosis.search.periodogram import find_lines, step_in
from gravcomp.diagnosis.thresholds import CORNER_PRICE, EMPIRICAL_PRICE, SCAN_PRICE, SURFACE_DEGREE
from gravcomp.logs.measurement import Measurement

_HINGE_POWERS = (1.0, 2.0)  # a spring behind the corner, and one that stiffens


@dataclass(frozen=True)
class Correction(Candidate):
    """What the residual of one axis (from 0) follows: ``variables`` for people, ``shape`` for the computation."""

    axis: int
    variables: tuple[Variable, ...]
    shape: tuple[float, ...] = ()
    by_direction: bool = False

    kind = ""
    price = EMPIRICAL_PRICE

    @property
    def name(self) -> str:
        return f"axis {self.axis + 1}: {' and '.join(self.variables)}"

    @property
    def is_of_position(self) -> bool:
        """Does it depend on positions (or model forces, which follow from them) alone?"""
        return all(variable.kind in ("q", "f") for variable in self.variables) and not self.by_direction

    @property
    def is_of_own_position(self) -> bool:
        return self.variables == (Variable("q", self.axis),)

    n_variables = 1

    def n_values(self) -> int:
        """How many coefficients this shape has; 0 where no number of them would do."""
        raise NotImplementedError

    def regressors(self, data: Measurement, rows=slice(None)) -> np.ndarray:
        """Columns (m, p) on its axis."""
        raise NotImplementedError

    def regressors_by_axis(self, data, rows, shape):
        own = self.regressors(data, rows)
        labels = tuple(Parameter(f"value_{k}") for k in range(own.shape[1]))
        return labels, tuple(own if i == self.axis and own.any() else None for i in range(data.n_axes))

    def wrong_with(self, n_values: int) -> str:
        """What is wrong with one read from a file, of so many values; empty where nothing is."""
        if self.n_variables and len(self.variables) != self.n_variables + (self.by_direction and self.kind == "table"):
            return f"variables: a {self.kind} has {self.n_variables}, by direction one more"
        wanted = self.n_values()
        if not wanted:
            return f"shape: {list(self.shape)} is no shape of a {self.kind}"
        return "" if wanted == n_values else f"values: {n_values} where this shape has {wanted}"

    def columns(self, data, shape=None):
        own = self.regressors(data).T
        return {Parameter(f"value_{k}"): on_axis(data, self.axis, column) for k, column in enumerate(own)}

    def predict(self, data, parameters):
        return on_axis(data, self.axis, self.regressors(data) @ np.array(list(parameters.values())))

    def jacobian(self, data, parameters):
        return self.columns(data)

    def follows(self, data, parameters, force):
        """The variable that its force varies with most first."""
        own = sorted(self.variables, key=lambda variable: -_explained(variable.of(data), force[:, self.axis]))
        return [(self.axis, variable) for variable in own]


class Table(Correction):
    """Hat functions over the knots ``shape`` of one variable, times the axis' direction if ``by_direction``."""

    kind = "table"

    def n_values(self):
        return len(self.shape) if len(self.shape) > 1 and (np.diff(self.shape) > 0).all() else 0

    def regressors(self, data, rows=slice(None)):
        x = self.variables[0].of(data)[rows]
        hats = np.column_stack([np.interp(x, self.shape, hat) for hat in np.eye(len(self.shape))])
        return hats * data.direction[rows][:, [self.axis]] if self.by_direction else hats


class Line(Correction):
    """One variable as it is."""

    kind = "line"

    def n_values(self):
        return 1 if not self.shape else 0

    def regressors(self, data, rows=slice(None)):
        return self.variables[0].of(data)[rows][:, None]


class Square(Correction):
    """A variable times its size, x |x|: drag that grows faster than the speed, an effort that saturates."""

    kind = "square"

    def n_values(self):
        return 1 if not self.shape else 0

    def regressors(self, data, rows=slice(None)):
        x = self.variables[0].of(data)[rows]
        return (x * np.abs(x))[:, None]


class Product(Correction):
    """Two variables, multiplied."""

    kind = "product"

    n_variables = 2

    def n_values(self):
        return 1 if not self.shape else 0

    def regressors(self, data, rows=slice(None)):
        return (self.variables[0].of(data)[rows] * self.variables[1].of(data)[rows])[:, None]


class Wave(Correction):
    """Sine and cosine of a frequency in time, ``shape`` in Hz."""

    kind = "wave"
    price = EMPIRICAL_PRICE + SCAN_PRICE
    is_scanned = True

    def n_values(self):
        return 2 if len(self.shape) == 1 and self.shape[0] > 0 else 0

    def regressors(self, data, rows=slice(None)):
        angle = 2.0 * np.pi * self.shape[0] * (data.t_s[rows] - data.t_s[0])
        return np.column_stack([np.sin(angle), np.cos(angle)])


class Step(Correction):
    """Another level from the time ``shape`` on."""

    kind = "step"

    def n_values(self):
        return 2 if len(self.shape) == 1 else 0

    def regressors(self, data, rows=slice(None)):
        late = data.t_s[rows] > self.shape[0]
        return np.column_stack([late, np.ones(len(late))]).astype(float)


class Hinge(Correction):
    """Nothing up to a corner, a power of the way beyond it: ``shape`` is the corner, the side (1 or -1), the power."""

    kind = "hinge"
    price = EMPIRICAL_PRICE + CORNER_PRICE

    def n_values(self):
        is_hinge = len(self.shape) == 3 and self.shape[1] in SIDES and self.shape[2] in _HINGE_POWERS
        return int(is_hinge)

    def regressors(self, data, rows=slice(None)):
        corner, side, power = self.shape
        return hinge(self.variables[0].of(data)[rows], corner, side, power)[:, None]


class Stops(Correction):
    """Hinges at both ends of a travel: ``shape`` is the lower corner, the upper one, the power."""

    kind = "stops"
    price = EMPIRICAL_PRICE + 2.0 * CORNER_PRICE

    def n_values(self):
        is_travel = len(self.shape) == 3 and self.shape[0] <= self.shape[1] and self.shape[2] in _HINGE_POWERS
        return 2 if is_travel else 0

    def regressors(self, data, rows=slice(None)):
        x, (low, high, power) = self.variables[0].of(data)[rows], self.shape
        return np.column_stack([hinge(x, low, -1.0, power), hinge(x, high, 1.0, power)])


class Surface(Correction):
    """Polynomial of all positions; ``shape`` holds centres, then half ranges."""

    kind = "surface"

    n_variables = 0

    def n_values(self):
        n = len(self.shape) // 2
        is_whole = n == len(self.variables) and 2 * n == len(self.shape) and all(half > 0 for half in self.shape[n:])
        return comb(n + SURFACE_DEGREE, SURFACE_DEGREE) if is_whole else 0

    def regressors(self, data, rows=slice(None)):
        centre, half = np.asarray(self.shape).reshape(2, -1)
        return PolynomialFeatures(SURFACE_DEGREE).fit_transform((data.q[rows] - centre) / half)


KINDS = {kind.kind: kind for kind in (Table, Line, Square, Product, Wave, Step, Hinge, Stops, Surface)}


def candidates(data: Measurement) -> list[Correction]:
    """Every correction that the search tries, those in time excepted: a scan of the residual proposes them."""
    out, n, every = [], len(data.t_s), variables(data)
    sizes = (7, 15) if n >= 600 else (6,)
    for axis in range(data.n_axes):
        direction = Variable("dir", axis)
        for variable in every:
            if variable.kind not in ("t", "temp"):
                out.append(Line(axis, (variable,)))
            if variable.kind == "dir":
                continue
            is_own = variable.axis == axis
            if is_own and variable.kind in ("v", "f"):
                out.append(Square(axis, (variable,)))
            fine = (30,) if n >= 600 and is_own and variable.kind == "q" else ()
            for size in sizes + fine:
                knots = _knots(variable.of(data), size)
                if len(knots) < 3:
                    continue
                out.append(Table(axis, (variable,), knots))
                if data.has_velocity and is_own and variable.kind in ("q", "f"):
                    out.append(Table(axis, (variable, direction), knots, by_direction=True))
        if 1 < data.n_axes <= 3 and n >= 200:
            centre, half = data.q.mean(axis=0), np.ptp(data.q, axis=0) / 2
            if (half > 0).all():
                out.append(Surface(axis, tuple(Variable("q", i) for i in range(data.n_axes)), (*centre, *half)))
        own = [Variable(kind, axis) for kind in ("q", "v")[: 1 + data.has_velocity]]
        others = [variable for variable in every if variable.kind in ("q", "v", "f") and variable not in own]
        out += [Product(axis, (a, b)) for a in own for b in others]
    return out


def scanned(data: Measurement, rows: np.ndarray, step: np.ndarray, wave: np.ndarray) -> list[Correction]:
    """Steps and waves in time that scans of two residuals (rows, k) propose."""
    out, time = [], (Variable("t"),)
    if data.axis_as_time is not None:
        return out
    for axis in range(data.n_axes):
        out.append(Step(axis, time, (step_in(data.t_s[rows], step[:, axis]),)))
        lines = find_lines(data.t_s[rows], wave[:, [axis]], 2)
        out += [Wave(axis, time, (frequency,)) for frequency, _ in lines]
    return out


def hinges(data: Measurement, rows: np.ndarray, of_position: np.ndarray, keep: np.ndarray) -> list[Correction]:
    """Hinges over its own position that a scan of what each axis has of it (rows, k) proposes, of the entries to keep
    (rows, k), and pairs of them: stops, slack ropes.
    """
    out = []
    for axis in range(data.n_axes):
        use, own = keep[:, axis], (Variable("q", axis),)
        x, y = data.q[rows[use], axis], of_position[use, axis]
        for power in _HINGE_POWERS:
            for side in SIDES:
                corner = corner_in(x, y, side, power)
                if corner is not None:
                    out.append(Hinge(axis, own, (corner, side, power)))
            both = corners_in(x, y, power)
            if both is not None:
                out.append(Stops(axis, own, (*both, power)))
    return out


def _knots(x: np.ndarray, size: int) -> tuple[float, ...]:
    uniform = np.linspace(x.min(), x.max(), size)
    filled = [uniform[0]]
    for knot in uniform[1:]:  # a knot only where at least a few samples lie between it and the last
        if np.count_nonzero((x > filled[-1]) & (x <= knot)) >= 4:
            filled.append(knot)
    filled[-1] = uniform[-1]  # no sample lies beyond: a straight line is always within the table
    return tuple(float(k) for k in filled)


def _explained(x: np.ndarray, y: np.ndarray, n_bins: int = 30) -> float:
    """Correlation ratio: variance of y between quantile bins of x."""
    edges = np.unique(np.quantile(x, np.linspace(0, 1, n_bins + 1)[1:-1]))
    bins = np.searchsorted(edges, x)
    count = np.bincount(bins, minlength=len(edges) + 1)
    mean = np.bincount(bins, y, len(edges) + 1) / np.maximum(count, 1)
    return float((count * (mean - y.mean()) ** 2).sum() - count.astype(bool).sum() * y.var())
