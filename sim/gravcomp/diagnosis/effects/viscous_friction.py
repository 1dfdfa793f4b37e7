"""Viscous friction."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.robot.mechanics import Mechanics


class ViscousFriction(Effect):
    """b_i v_i."""

    name = "viscous_friction"
    driver = "v"
    equation = "b_i v_i, or b_pos_i v_i for v_i > 0 and b_neg_i v_i for v_i < 0"
    hardware = "compensator"
    units = {"b": "[f] s/[q]", "b_pos": "[f] s/[q]", "b_neg": "[f] s/[q]"}  # noqa: RUF012
    positive = ("b",)
    complexity = "common"
    is_simple = True
    is_linear = True

    unavailable = staticmethod(needs_velocity)

    def columns(self, data, shape):
        return by_axis(data, "b", data.v)

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for i in range(data.n_axes):
            v = data.v[:, i]
            up, down = parameters.get(Parameter("b_pos", i), 0.0), parameters.get(Parameter("b_neg", i), 0.0)
            force[:, i] = (parameters.get(Parameter("b", i), 0.0) + np.where(v > 0, up, down)) * v
        return force

    def mechanics(self, robot, parameters):
        """Of damping by direction the mean: a file has one number."""
        both, up, down = (per_axis(parameters, stem, robot.n_axes) for stem in ("b", "b_pos", "b_neg"))
        return Mechanics(damping=dict(enumerate(both + (up + down) / 2)))

    def constants(self, data, parameters):
        both, up, down = (per_axis(parameters, stem, data.n_axes) for stem in ("b", "b_pos", "b_neg"))
        return {"b_pos": both + up, "b_neg": both + down}


class DirectionalViscousFriction(ViscousFriction):
    """b_pos_i v_i for v_i > 0, b_neg_i v_i for v_i < 0."""

    complexity = "general"
    differs_with = "coulomb_friction"
    positive = ("b_pos", "b_neg")

    def columns(self, data, shape):
        return by_axis(data, "b_pos", np.maximum(data.v, 0.0)) | by_axis(data, "b_neg", np.minimum(data.v, 0.0))
