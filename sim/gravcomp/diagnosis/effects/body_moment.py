"""Masses that the model of a robot does not know, or has at the wrong places, on any of its bodies."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.thresholds import INDEPENDENT, TINY
from gravcomp.robot.mechanics import Mechanics


class BodyMoment(Effect):
    """Gravity of an extra first moment m r on bodies of the robot, each in the frame of its body."""

    name = "body_moment"
    driver = "q"
    equation = "gravity of an extra first moment m r on a body, by name"
    hardware = "network"
    units = {"moment": "kg m"}  # noqa: RUF012
    per_axis = False
    complexity = "uncommon"
    special_case = "payload"

    def unavailable(self, data):
        if data.body_moments is None:
            return "the bodies of the robot are not known"
        return "" if np.abs(data.body_moments).max() > TINY else "no axis feels where on its body a mass is"

    def columns(self, data, shape):
        """No sums of others among them: of moments that show only together the body nearest to the base has the sum."""
        every = _regressors(data)
        flat = np.column_stack([column.ravel() for column in every.values()])
        left = np.abs(np.diag(np.linalg.qr(flat, mode="r"))) / max(np.linalg.norm(flat, axis=0).max(), TINY)
        return {label: column for (label, column), own in zip(every.items(), left, strict=True) if own > INDEPENDENT}

    def predict(self, data, parameters):
        every = _regressors(data)
        return sum((value * every[label] for label, value in parameters.items()), np.zeros(data.shape))

    def mechanics(self, robot, parameters):
        moments = {_body(label): np.zeros(3) for label in parameters}
        for label, value in parameters.items():
            moments[_body(label)]["xyz".index(label[-1])] += value
        return Mechanics(moments_kgm=moments)

    def groups(self, labels):
        """Bodies stay or go whole."""
        bodies = dict.fromkeys(_body(label) for label in labels)
        return [{label for label in labels if _body(label) == body} for body in bodies]


def _regressors(data) -> dict[Parameter, np.ndarray]:
    """(n, k) by parameter, bodies from the base outward."""
    return {
        Parameter(f"moment_{body}_{axis}"): data.body_moments[..., b, a]
        for b, body in enumerate(data.robot.body_names)
        for a, axis in enumerate("xyz")
    }


def _body(label: str) -> str:
    return label.removeprefix("moment_")[:-2]
