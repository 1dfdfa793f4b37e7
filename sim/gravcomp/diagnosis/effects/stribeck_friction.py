"""Friction that falls from its static to its sliding value as speed grows."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, on_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.robot.mechanics import Mechanics


class StribeckFriction(Effect):
    """(fc_i + (fs_i - fc_i) exp(-(v_i/vs_i)^2)) sign(v_i), 0 <= fc_i <= fs_i."""

    name = "stribeck_friction"
    driver = "v"
    equation = "(fc_i + (fs_i - fc_i) exp(-(v_i/vs_i)^2)) sign(v_i)"
    hardware = "compensator"
    units = {"fc": "[f]", "fs": "[f]", "vs": "[q]/s"}  # noqa: RUF012
    positive = ("fc", "fs")
    scales = ("vs",)
    special_case = "coulomb_friction"
    complexity = "rarer"

    unavailable = staticmethod(needs_velocity)

    def shapes(self, data):
        speed = np.quantile(np.abs(data.v), [0.5, 0.95], axis=0)
        if (speed[1] <= 1.05 * speed[0]).all():
            return []
        fractions = (0.05, 0.1, 0.17, 0.27, 0.4, 0.6, 0.9)
        return [{Parameter("vs", i): float(f * max(speed[1, i], 1e-9)) for i in range(data.n_axes)} for f in fractions]

    def columns(self, data, shape):
        out = {}
        for i in range(data.n_axes):
            if Parameter("vs", i) in shape:
                fall = np.exp(-((data.v[:, i] / shape[Parameter("vs", i)]) ** 2))
                out[Parameter("fc", i)] = on_axis(data, i, (1.0 - fall) * data.direction[:, i])
                out[Parameter("fs", i)] = on_axis(data, i, fall * data.direction[:, i])
        return out

    def contrasts(self, labels):
        falls = [{Parameter("fs", label.axis): 1.0, label: -1.0} for label in labels if label.stem == "fc"]
        return super().contrasts(labels) + falls

    def mechanics(self, robot, parameters):
        """Its sliding level: a file has no other."""
        return Mechanics(friction=dict(enumerate(per_axis(parameters, "fc", robot.n_axes))))

    def allowance(self, label, known):
        """At rest the model has its own fs, and the fc of its other frictions."""
        if label.stem != "fs":
            return super().allowance(label, known)
        stems = {name: "fs" if name == self.name else "fc" for name in known}
        return max(sum(own.get(Parameter(stems[name], label.axis), 0.0) for name, own in known.items()), 0.0)

    def constants(self, data, parameters):
        fc, fs, vs = (per_axis(parameters, stem, data.n_axes) for stem in ("fc", "fs", "vs"))
        return {"fc_pos": fc, "fc_neg": fc, "stribeck": fs - fc, "vs": vs}
