"""Viscous friction."""

import numpy as np

from gravcomp.diagnosis.effects.base import Effect, by_axis, needs_velocity


class ViscousFriction(Effect):
    """b_i v_i."""

    name = "viscous_friction"
    follows = "v"
    equation = "b_i v_i, or b_pos_i v_i for v_i > 0 and b_neg_i v_i for v_i < 0"
    hardware = "compensator"
    units = {"b": "[f] s/[q]", "b_pos": "[f] s/[q]", "b_neg": "[f] s/[q]"}  # noqa: RUF012
    positive = ("b",)
    complexity = 1.0

    unavailable = staticmethod(needs_velocity)

    def columns(self, data, shape):
        return by_axis(data, "b", data.v)

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for i in range(data.n_axes):
            v = data.v[:, i]
            up, down = parameters.get(f"b_pos_{i + 1}", 0.0), parameters.get(f"b_neg_{i + 1}", 0.0)
            force[:, i] = (parameters.get(f"b_{i + 1}", 0.0) + np.where(v > 0, up, down)) * v
        return force


class DirectionalViscousFriction(ViscousFriction):
    """b_pos_i v_i for v_i > 0, b_neg_i v_i for v_i < 0."""

    complexity = 6.0
    positive = ("b_pos", "b_neg")

    def columns(self, data, shape):
        return by_axis(data, "b_pos", np.maximum(data.v, 0.0)) | by_axis(data, "b_neg", np.minimum(data.v, 0.0))
