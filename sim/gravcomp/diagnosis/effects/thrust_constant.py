"""The motor gives another force per ampere than assumed."""

import numpy as np

from gravcomp.diagnosis.candidate import by_axis
from gravcomp.diagnosis.effects.base import Effect


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
