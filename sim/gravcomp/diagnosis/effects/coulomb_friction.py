"""Coulomb friction, symmetric or different by direction."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.robot.mechanics import Mechanics


class CoulombFriction(Effect):
    """fc_i sign(v_i)."""

    name = "coulomb_friction"
    driver = "dir"
    equation = "fc_i sign(v_i), or fc_pos_i for v_i > 0 and -fc_neg_i for v_i < 0"
    hardware = "compensator"
    units = {"fc": "[f]", "fc_pos": "[f]", "fc_neg": "[f]"}  # noqa: RUF012
    positive = ("fc",)
    is_simple = True
    is_linear = True

    unavailable = staticmethod(needs_velocity)

    def columns(self, data, shape):
        return by_axis(data, "fc", data.direction)

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for i in range(data.n_axes):
            s = data.direction[:, i]
            up, down = parameters.get(Parameter("fc_pos", i), 0.0), parameters.get(Parameter("fc_neg", i), 0.0)
            force[:, i] = parameters.get(Parameter("fc", i), 0.0) * s + np.where(s > 0, up, np.where(s < 0, -down, 0.0))
        return force

    def same_as(self, parameters):
        """By direction it is a symmetric one and an offset of (fc_pos - fc_neg)/2."""
        return ("current_offset",) if any(name.startswith("fc_pos") for name in parameters) else ()

    def mechanics(self, robot, parameters):
        """Of friction by direction the mean: a file has one level."""
        both, up, down = (per_axis(parameters, stem, robot.n_axes) for stem in ("fc", "fc_pos", "fc_neg"))
        return Mechanics(friction=dict(enumerate(both + (up + down) / 2)))

    def constants(self, data, parameters):
        both, up, down = (per_axis(parameters, stem, data.n_axes) for stem in ("fc", "fc_pos", "fc_neg"))
        return {"fc_pos": both + up, "fc_neg": both + down}


class DirectionalCoulombFriction(CoulombFriction):
    """fc_pos_i for v_i > 0, -fc_neg_i for v_i < 0: the same as a symmetric one and an offset of (fc_pos - fc_neg)/2."""

    complexity = "common"
    positive = ("fc_pos", "fc_neg")

    def columns(self, data, shape):
        up = by_axis(data, "fc_pos", (data.direction > 0).astype(float))
        return up | by_axis(data, "fc_neg", -(data.direction < 0).astype(float))
