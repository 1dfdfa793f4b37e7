"""What every effect is: a name, an equation, regressors for the search, an exact prediction, a place in hardware.

An effect is added to the model: f_exp = f_model(q) + sum of effects. For given shape parameters (a velocity, a pitch,
a time constant) it is linear in the rest, so the search needs only ``columns``; the final fit calls ``predict``.
"""

import re

import numpy as np

from gravcomp.logs.measurement import Measurement

_AXIS = re.compile(r"_(\d+)(?:_|$)")


class Effect:
    """Base class. Parameters end in the axis they belong to (``b_1``) where the effect acts axis by axis."""

    name = ""
    equation = ""
    follows = ""  # stem of the measured variable it is a function of: q, v, dir, f, a (each axis its own), or t
    hardware = "none"  # "network": retrained statics; "compensator": friction or position table; "none"
    units: dict[str, str] = {}  # noqa: RUF012 - parameter stem -> unit, with [q] and [f] for position and effort
    per_axis = True
    positive: tuple[str, ...] = ()  # stems of labels whose coefficients can only be >= 0
    special_case = ""  # the effect that this one contains
    complexity = 0.0  # added to the information criterion: of two equal explanations the usual one is named

    def unavailable(self, data: Measurement) -> str:
        """Why this data cannot show the effect; empty when it can."""
        return ""

    def shapes(self, data: Measurement) -> list[dict]:
        """Shape parameters that the search tries."""
        return [{}]

    def columns(self, data: Measurement, shape: dict) -> dict[str, np.ndarray]:
        """Regressors (n, k) by label; the effect is their linear combination (to first order)."""
        raise NotImplementedError

    def parameters(self, shape: dict, coefficients: dict[str, float]) -> dict[str, float]:
        """Physical parameters from the shape and the coefficients of the regressors."""
        return {**coefficients, **shape}

    def predict(self, data: Measurement, parameters: dict[str, float]) -> np.ndarray:
        """The effect's force, (n, k), in the unit of the data."""
        columns = self.columns(data, parameters)
        return sum((parameters[label] * column for label, column in columns.items() if label in parameters),
                   np.zeros(data.shape))  # fmt: skip

    def groups(self, labels: tuple[str, ...]) -> list[set[str]]:
        """Labels that stay or go together when an axis has no part in the effect."""
        if not self.per_axis:
            return []
        axes = sorted({axis_of(label) for label in labels})
        return [{label for label in labels if axis_of(label) == axis} for axis in axes]

    def contrasts(self, labels: list[str]) -> list[dict[str, float]]:
        """Sums of coefficients that can only be >= 0."""
        return [{label: 1.0} for label in labels if stem_of(label) in self.positive]


def on_axis(data: Measurement, axis: int, column: np.ndarray) -> np.ndarray:
    """A regressor (n, k) that acts on one axis (from 0) only; column (n,)."""
    full = np.zeros(data.shape)
    full[:, axis] = column
    return full


def by_axis(data: Measurement, stem: str, matrix: np.ndarray) -> dict[str, np.ndarray]:
    """One regressor per axis from the columns of matrix (n, k), labelled stem_1, stem_2, ..."""
    return {f"{stem}_{i + 1}": on_axis(data, i, matrix[:, i]) for i in range(data.n_axes)}


def axis_of(label: str) -> int | None:
    """Axis (from 0) that a label ends in or names."""
    match = _AXIS.search(label)
    return int(match[1]) - 1 if match else None


def stem_of(label: str) -> str:
    return _AXIS.split(label)[0]


def axes_in(parameters: dict[str, float], stem: str) -> list[int]:
    """Axes (from 0) that have a parameter of this stem."""
    return sorted(axis_of(label) for label in parameters if stem_of(label) == stem)


def needs_velocity(data: Measurement) -> str:
    return "" if data.has_velocity else "no velocity"


def needs_function(data: Measurement) -> str:
    return "" if data.force_at is not None else "the model is known at the samples only, not as a function of position"
