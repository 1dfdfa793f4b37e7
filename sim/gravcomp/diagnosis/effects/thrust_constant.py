"""The motor gives another force per ampere than assumed."""

import numpy as np

from gravcomp.diagnosis.candidate import by_axis
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.samples.sensors import gains, is_a_gain


class ThrustConstant(Effect):
    """gain_i f_model_i."""

    name = "thrust_constant"
    driver = "f"
    equation = "gain_i f_model_i"
    hardware = "network"
    remedy = "hang a known mass on the machine and log again"
    units = {"gain": "1"}  # noqa: RUF012
    is_simple = True
    limits = {"gain": 0.5}  # noqa: RUF012 - beyond it is a sign or a unit

    def unavailable(self, data):
        return "" if np.any(data.nominal) else "the model is zero"

    def columns(self, data, shape):
        return by_axis(data, "gain", data.nominal)

    def regressors_by_axis(self, data, rows, shape):
        """Of the axes whose effort is near the model's: elsewhere the unit or the model is of another machine."""
        labels, by_axis = super().regressors_by_axis(data, rows, shape)
        is_near = np.array([is_a_gain(gain) for gain in data.once(gains)])
        kept = tuple(label for label, near in zip(labels, is_near, strict=True) if near)
        return kept, tuple(
            own[:, is_near] if near and own is not None else None for own, near in zip(by_axis, is_near, strict=True)
        )
