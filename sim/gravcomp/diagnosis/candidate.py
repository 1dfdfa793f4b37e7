"""What competes to explain a residual: one base for effects, which have a name, and corrections, which have none.

A candidate of a given shape (a velocity, a pitch, a time constant) is linear in its coefficients, so the search needs
only ``columns``; the final fit calls ``predict``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.polynomial.legendre import leggauss

from gravcomp.diagnosis.thresholds import DIFFERENCE_STEP
from gravcomp.logs.measurement import Measurement


class Variable(str):
    """A measured variable by the name that the report uses: q1, v1, dir1, f1 (model), a1, t, temp."""

    kind: str
    axis: int | None

    def __new__(cls, kind: str, axis: int | None = None):
        self = super().__new__(cls, kind if axis is None else f"{kind}{axis + 1}")
        self.kind, self.axis = kind, axis
        return self

    def __getnewargs__(self):
        return self.kind, self.axis

    @classmethod
    def parse(cls, name: str) -> "Variable":
        """Raises ValueError for a name that is none."""
        kind = name.rstrip("0123456789")
        axis = int(name[len(kind) :]) - 1 if len(name) > len(kind) else None
        if kind not in _SOURCE or (axis is None) != (kind in ("t", "temp")) or (axis or 0) < 0:
            raise ValueError(f"{name!r} is no variable; use one of q1, v1, dir1, f1, a1, t, temp")
        return cls(kind, axis)

    def is_in(self, data: Measurement) -> bool:
        """Has the log such a column?"""
        try:
            return getattr(data, _SOURCE[self.kind]) is not None
        except TypeError:  # a direction, where no velocity is
            return False

    def of(self, data: Measurement) -> np.ndarray:
        """Its values, (n,)."""
        values = getattr(data, _SOURCE[self.kind])
        return values if self.axis is None else values[:, self.axis]


_SOURCE = {"q": "q", "v": "v", "dir": "direction", "f": "nominal", "a": "acceleration", "t": "t_s", "temp": "temp_c"}


def variables(data: Measurement) -> list[Variable]:
    """Every measured variable that varies in this data."""
    kinds = ["q", "f"] + (["v", "dir"] if data.has_velocity else [])
    own = [Variable(kind, axis) for pair in (kinds[:2], kinds[2:]) for kind in pair for axis in range(data.n_axes)]
    own += ([Variable("t")] if data.axis_as_time is None else []) + (
        [Variable("temp")] if data.temp_c is not None else []
    )
    return [variable for variable in own if np.ptp(variable.of(data)) > 0.0]


class Parameter(str):
    """A parameter by the name that report and model use: fc_1, amplitude_2_h3, pitch; axis from 0."""

    stem: str
    axis: int | None
    harmonic: int | None

    def __new__(cls, stem: str, axis: int | None = None, harmonic: int | None = None):
        name = stem if axis is None else f"{stem}_{axis + 1}"
        self = super().__new__(cls, name if harmonic is None else f"{name}_h{harmonic}")
        self.stem, self.axis, self.harmonic = stem, axis, harmonic
        return self

    def __getnewargs__(self):
        return self.stem, self.axis, self.harmonic

    @classmethod
    def parse(cls, name: str) -> "Parameter":
        """The parameter of a name in a file: an axis and a harmonic are its last parts."""
        parts, harmonic = name.split("_"), None
        if len(parts) > 2 and parts[-1][:1] == "h" and parts[-1][1:].isdigit():
            harmonic = int(parts.pop()[1:])
        if len(parts) > 1 and parts[-1].isdigit() and int(parts[-1]) > 0:
            return cls("_".join(parts[:-1]), int(parts[-1]) - 1, harmonic)
        return cls(name)


class Candidate:
    """Base of effects and corrections; forces (n, k) in the unit of the data."""

    name: str
    price: float  # added to the score of a set
    special_case = ""  # name of the candidate that this one contains
    differs_with = ""  # name of the one that differs by direction too where this one does
    scales: tuple[str, ...] = ()  # stems of shape parameters, which are > 0
    limits: Mapping[str, float] = {}
    is_simple = False  # two of these together may stand for another
    is_curved = False  # its columns are those of small parameters, which bear the names of the columns
    is_scanned = False  # sought by a scan of what is left
    is_by_axis = False  # an effect of each axis by itself
    is_of_own_position = False  # on each axis a function of its position alone

    def columns(self, data: Measurement, shape: Mapping) -> dict[Parameter, np.ndarray]:
        """Regressors (n, k) by parameter; the force is their linear combination (to first order)."""
        raise NotImplementedError

    def regressors_by_axis(self, data: Measurement, rows: np.ndarray, shape: Mapping):
        """Labels of the columns, and per axis the columns (m, p) on some rows; None where an axis has no part."""
        columns = self.columns(data, shape)
        stacked = np.stack([column[rows] for column in columns.values()], axis=-1)
        return tuple(columns), tuple(own if own.any() else None for own in stacked.transpose(1, 0, 2))

    def parameters(self, shape: Mapping, coefficients: Mapping[Parameter, float]) -> dict[Parameter, float]:
        """Parameters from the shape and the coefficients of the regressors."""
        return {**coefficients, **shape}

    def predict(self, data: Measurement, parameters: Mapping[str, float]) -> np.ndarray:
        """The force (n, k)."""
        columns = self.columns(data, parameters)
        return sum((parameters[name] * column for name, column in columns.items() if name in parameters),
                   np.zeros(data.shape))  # fmt: skip

    @property
    def is_linear(self) -> bool:
        """Is the force exactly the sum of parameters times columns, which depend on none of them?"""
        return type(self).predict is Candidate.predict and not self.scales

    def jacobian(self, data: Measurement, parameters: Mapping[str, float]) -> dict[str, np.ndarray]:
        """Derivative (n, k) of the force by each parameter: columns where it is their sum, else differences."""
        is_sum = type(self).predict is Candidate.predict
        exact = self.columns(data, parameters) if is_sum else {}
        out = {name: exact[name] for name in parameters if name in exact}
        others = [name for name in parameters if name not in out]
        here = self.predict(data, parameters) if others else None
        for name in others:
            step = DIFFERENCE_STEP * max(abs(parameters[name]), 1e-9)
            out[name] = (self.predict(data, {**parameters, name: parameters[name] + step}) - here) / step
        return out

    def columns_to(self, data: Measurement, parameters: Mapping[str, float]) -> dict[str, np.ndarray]:
        """Regressors (n, k) whose combination with these parameters is the force: its derivatives, averaged along the
        straight way from none to them (the fundamental theorem of calculus, by Gauss's rule of three points).
        """
        curved = {name: value for name, value in parameters.items() if Parameter.parse(name).stem not in self.scales}
        total = {}
        for node, weight in zip(*leggauss(3), strict=True):
            here = {name: 0.5 * (1.0 + node) * value for name, value in curved.items()}
            by_name = self.jacobian(data, {**parameters, **here})
            for name in curved:
                total[name] = total.get(name, 0.0) + 0.5 * weight * by_name[name]
        return total

    def limits_in(self, data: Measurement) -> Mapping[str, float]:
        """Largest sizes of parameters, by stem or by name, that this data leaves possible."""
        return self.limits

    def groups(self, labels: tuple[Parameter, ...]) -> list[set[Parameter]]:
        """Labels that stay or go together when an axis has no part in it; none: all stay."""
        return []

    def contrasts(self, labels: tuple[Parameter, ...]) -> list[dict[Parameter, float]]:
        """Sums of coefficients that can only be >= 0."""
        return []

    def allowance(self, label: Parameter, known: Mapping[str, Mapping[str, float]]) -> float:
        """How far below zero a coefficient of a contrast may be, where the model has ``known`` parameters by effect."""
        return 0.0

    def reduces(self, intervals: Mapping[str, tuple[float, float]]) -> bool:
        """Do these 95 % intervals say that its special case is enough?"""
        return False

    def follows(
        self, data: Measurement, parameters: Mapping[str, float], force: np.ndarray
    ) -> list[tuple[int, Variable]]:
        """Axes and the measured variables that this force (n, k) of the candidate is a function of, the first first."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Term:
    """One candidate with one shape; labels name its columns, which of a curved one are those to the parameters
    ``about``.
    """

    candidate: Candidate
    labels: tuple[Parameter, ...]
    shape: Mapping = field(default_factory=dict)
    limits: Mapping[str, float] = field(default_factory=dict)
    about: Mapping[str, float] = field(default_factory=dict)

    def limit(self, label: str) -> float:
        """The largest size of a parameter; infinite without one."""
        return self.limits.get(label, self.limits.get(getattr(label, "stem", label), np.inf))

    @property
    def name(self) -> str:
        return self.candidate.name

    def columns(self, data: Measurement) -> np.ndarray:
        """(n, k, p)."""
        own, about = self.candidate, self.about
        columns = own.columns_to(data, about) if about else own.columns(data, self.shape)
        return np.stack([columns[label] for label in self.labels], axis=-1)


@dataclass(frozen=True, eq=False)
class Regressor:
    """A term and its columns per axis on the rows of the search: (m, p), or None where an axis has no part."""

    term: Term
    by_axis: tuple[np.ndarray | None, ...]

    @classmethod
    def of(cls, candidate: Candidate, data: Measurement, rows: np.ndarray, shape: Mapping = {}) -> "Regressor":
        labels, by_axis = candidate.regressors_by_axis(data, rows, shape)
        return cls(Term(candidate, labels, shape, candidate.limits_in(data)), by_axis)

    @classmethod
    def about(cls, term: Term, data: Measurement, rows: np.ndarray, parameters: Mapping) -> "Regressor":
        """A curved term as it is at these parameters."""
        term = replace(term, about=parameters)
        columns = term.columns(data)[rows]
        return cls(term, tuple(own if own.any() else None for own in columns.transpose(1, 0, 2)))

    @property
    def has_part(self) -> bool:
        return any(column is not None for column in self.by_axis)


def on_axis(data: Measurement, axis: int, column: np.ndarray) -> np.ndarray:
    """A regressor (n, k) that acts on one axis (from 0) only; column (n,)."""
    full = np.zeros(data.shape)
    full[:, axis] = column
    return full


def by_axis(data: Measurement, stem: str, matrix: np.ndarray) -> dict[Parameter, np.ndarray]:
    """One regressor per axis from the columns of matrix (n, k), labelled stem_1, stem_2, ..."""
    return {Parameter(stem, i): on_axis(data, i, matrix[:, i]) for i in range(data.n_axes)}


def axes_in(parameters: Mapping[str, float], stem: str) -> list[int]:
    """Axes (from 0) that have a parameter of this stem."""
    own = [Parameter.parse(name) for name in parameters]
    return sorted(name.axis for name in own if name.stem == stem and name.axis is not None)


def per_axis(parameters: Mapping[str, float], stem: str, n_axes: int) -> np.ndarray:
    """Parameters stem_1, stem_2, ..., (n_axes,); zero where an axis has none."""
    return np.array([parameters.get(Parameter(stem, axis), 0.0) for axis in range(n_axes)])
