"""The effort of an axis is logged with the wrong sign."""

from dataclasses import replace

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.samples.sensors import inverted


class SensorSign(Effect):
    """sign_i = -1: the measured effort of axis i is the opposite of the true one."""

    name = "sensor_sign"
    driver = "f"
    equation = "f_exp_i = sign_i times the true effort, sign_i = -1"
    hardware = "none"
    sensor = "the sign of the effort"
    units = {"sign": "1"}  # noqa: RUF012

    def shapes(self, data):
        return []

    def seen_in(self, data):
        return {Parameter("sign", i): (-1.0, 0.0) for i in inverted(data)}

    def corrected(self, data, parameters):
        sign = np.array([parameters.get(Parameter("sign", i), 1.0) for i in range(data.n_axes)])
        return replace(data, force=data.force * sign)

    def columns(self, data, shape):
        return {}
