"""A cable or hose that pulls like a spring."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, axes_in, by_axis
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.mechanics import Mechanics


class CableSpring(Effect):
    """k_i (q_i - q0_i)."""

    name = "cable_spring"
    driver = "q"
    equation = "k_i (q_i - q0_i)"
    hardware = "network"
    units = {"k": "[f]/[q]", "q0": "[q]"}  # noqa: RUF012
    complexity = "usual"
    is_simple = True
    special_case = "current_offset"

    def reduces(self, intervals):
        """A spring whose k is not different from zero is an offset."""
        return all(low <= 0.0 <= high for name, (low, high) in intervals.items() if name.startswith("k_"))

    def same_as(self, parameters):
        return ("current_offset",)  # they differ by q0 only

    def columns(self, data, shape):
        return by_axis(data, "k", data.q) | by_axis(data, "c", np.ones(data.shape))

    def parameters(self, shape, coefficients):
        out = {}
        for i in axes_in(coefficients, "k"):
            k, c = coefficients[Parameter("k", i)], coefficients[Parameter("c", i)]
            out |= {Parameter("k", i): k, Parameter("q0", i): -c / k if k else 0.0}
        return out

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for i in axes_in(parameters, "k"):
            force[:, i] = parameters[Parameter("k", i)] * (data.q[:, i] - parameters[Parameter("q0", i)])
        return force

    def mechanics(self, robot, parameters):
        return Mechanics(
            springs={
                i: (parameters[Parameter("k", i)], parameters[Parameter("q0", i)]) for i in axes_in(parameters, "k")
            }
        )
