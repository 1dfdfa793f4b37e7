"""Friction in proportion to the load."""

import numpy as np

from gravcomp.diagnosis.candidate import by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity


class LoadDependentFriction(Effect):
    """mu_i |f_model_i| sign(v_i)."""

    name = "load_dependent_friction"
    driver = "dir"
    equation = "mu_i abs(f_model_i) sign(v_i)"
    hardware = "compensator"
    remedy = "hang a known mass on the machine and log again"
    units = {"mu": "1"}  # noqa: RUF012
    positive = ("mu",)
    complexity = "common"

    def unavailable(self, data):
        return needs_velocity(data) or ("" if np.any(data.nominal) else "the model is zero")

    def columns(self, data, shape):
        return by_axis(data, "mu", np.abs(data.nominal) * data.direction)

    def constants(self, data, parameters):
        return {"mu": per_axis(parameters, "mu", data.n_axes)}
