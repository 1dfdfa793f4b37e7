"""Play between encoder and joint: the joint lags by half the gap."""

import numpy as np

from gravcomp.measured.effects.base import Effect, needs_function, needs_velocity


class Backlash(Effect):
    """f_model(q - gap/2 sign(v)) - f_model(q)."""

    name = "backlash"
    follows = "dir"
    equation = "f_model(q - gap/2 sign(v)) - f_model(q)"
    hardware = "none"
    units = {"gap": "[q]"}  # noqa: RUF012
    positive = ("gap",)
    per_axis = False
    complexity = 2.0

    def unavailable(self, data):
        return needs_velocity(data) or needs_function(data)

    def columns(self, data, shape):
        lag = -0.5 * data.sensitivity * data.direction[:, None, :]
        return {f"gap_{j + 1}": lag[..., j] for j in range(data.n_axes)}

    def predict(self, data, parameters):
        gap = np.array([parameters.get(f"gap_{j + 1}", 0.0) for j in range(data.n_axes)])
        return data.force_at(data.q - 0.5 * gap * data.direction) - data.force_at(data.q)
