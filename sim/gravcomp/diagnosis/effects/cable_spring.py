"""A cable or hose that pulls like a spring."""

import numpy as np

from gravcomp.diagnosis.effects.base import Effect, axes_in, by_axis


class CableSpring(Effect):
    """k_i (q_i - q0_i)."""

    name = "cable_spring"
    follows = "q"
    equation = "k_i (q_i - q0_i)"
    hardware = "network"
    units = {"k": "[f]/[q]", "q0": "[q]"}  # noqa: RUF012
    complexity = 0.5

    def columns(self, data, shape):
        return by_axis(data, "k", data.q) | by_axis(data, "c", np.ones(data.shape))

    def parameters(self, shape, coefficients):
        out = {}
        for i in axes_in(coefficients, "k"):
            k, c = coefficients[f"k_{i + 1}"], coefficients[f"c_{i + 1}"]
            out |= {f"k_{i + 1}": k, f"q0_{i + 1}": -c / k if k else 0.0}
        return out

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for i in axes_in(parameters, "k"):
            force[:, i] = parameters[f"k_{i + 1}"] * (data.q[:, i] - parameters[f"q0_{i + 1}"])
        return force
