"""The force per ampere changes as the motor warms up: over time, or over temperature where it is measured."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, Variable, axes_in, by_axis
from gravcomp.diagnosis.effects.base import Effect, needs_time


class ThermalDrift(Effect):
    """gain_i (1 - exp(-t/tau)) f_model_i, or gain_i (T - T0_i) f_model_i."""

    name = "thermal_drift"
    equation = "gain (1 - exp(-t/tau)) f_model, or gain (T - T0) f_model"
    hardware = "none"
    remedy = "hang a known mass on the machine and log again"
    units = {"gain": "1 or 1/K", "tau": "s", "t0": "degC"}  # noqa: RUF012
    complexity = "uncommon"
    scales = ("tau_s",)

    def unavailable(self, data):
        if not np.any(data.nominal):
            return "the model is zero"
        return "" if _has_temperature(data) else needs_time(data)

    def follows(self, data, parameters, force):
        variable = Variable("t" if "tau_s" in parameters else "temp")
        return [(int(axis), variable) for axis in np.flatnonzero(force.any(axis=0))]

    def shapes(self, data):
        span, over_time = np.ptp(data.t_s), []
        if span > 0 and not needs_time(data):
            over_time = [{Parameter("tau_s"): f * span} for f in (0.03, 0.07, 0.15, 0.3, 0.6, 1.2, 3.0)]
        return over_time + ([{}] if _has_temperature(data) else [])

    def columns(self, data, shape):
        if "tau_s" not in shape:
            warm = by_axis(data, "slope", data.temp_c[:, None] * data.nominal)
            return warm | by_axis(data, "level", data.nominal)
        return by_axis(data, "gain", _rise(data, shape["tau_s"])[:, None] * data.nominal)

    def parameters(self, shape, coefficients):
        if "tau_s" in shape:
            return {**coefficients, **shape}
        out = {}
        for i in axes_in(coefficients, "slope"):
            slope, level = coefficients[Parameter("slope", i)], coefficients[Parameter("level", i)]
            out |= {Parameter("gain", i): slope, Parameter("t0", i): -level / slope if slope else 0.0}
        return out

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        if "tau_s" in parameters:
            rise = _rise(data, parameters["tau_s"])
            for i in axes_in(parameters, "gain"):
                force[:, i] = parameters[Parameter("gain", i)] * rise * data.nominal[:, i]
            return force
        if data.temp_c is None:
            raise ValueError("a drift over temperature, and no temp_c")
        for i in axes_in(parameters, "gain"):
            force[:, i] = (
                parameters[Parameter("gain", i)] * (data.temp_c - parameters[Parameter("t0", i)]) * data.nominal[:, i]
            )
        return force


def _rise(data, tau_s: float) -> np.ndarray:
    return 1.0 - np.exp(-(data.t_s - data.t_s[0]) / tau_s)


def _has_temperature(data) -> bool:
    return data.temp_c is not None and np.ptp(data.temp_c) > 0.0
