"""Friction that builds up over a short travel after each reversal (Dahl, 1968)."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, axes_in, on_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.running import after_lines, next_told


class PreslidingHysteresis(Effect):
    """fc_i z_i with dz = (sign(dq) - z) |dq|/s_i: z goes to the sign of the motion over the travel s_i."""

    name = "presliding_hysteresis"
    driver = "dir"
    equation = "fc_i z_i, dz_i = (sign(dq_i) - z_i) abs(dq_i)/s_i"
    hardware = "compensator"
    units = {"fc": "[f]", "s": "[q]"}  # noqa: RUF012
    positive = ("fc",)
    scales = ("s",)
    special_case = "coulomb_friction"
    complexity = "rarer"

    def unavailable(self, data):
        return "" if data.has_velocity and data.is_motion.mean() > 0.3 else "no motion along time"

    def shapes(self, data):
        travel = np.ptp(data.q, axis=0)
        fractions = (0.004, 0.01, 0.02, 0.04, 0.08, 0.16)
        return [{Parameter("s", i): f * travel[i] for i in range(data.n_axes)} for f in fractions]

    def columns(self, data, shape):
        return {
            Parameter("fc", i): on_axis(data, i, _state(data, i, shape[Parameter("s", i)]))
            for i in range(data.n_axes)
            if Parameter("s", i) in shape
        }

    def doubt(self, data, parameters):
        """How it stood when a motion began is not told, and fades along the travel."""
        force = np.zeros(data.shape)
        for i in axes_in(parameters, "s"):
            up, down = (_state(data, i, parameters[Parameter("s", i)], start) for start in (1.0, -1.0))
            force[:, i] = abs(parameters.get(Parameter("fc", i), 0.0)) * (up - down)
        return force

    def constants(self, data, parameters):
        """The friction that it ends in."""
        fc = per_axis(parameters, "fc", data.n_axes)
        return {"fc_pos": fc, "fc_neg": fc}


def _state(data, axis: int, travel: float, start: float | None = None) -> np.ndarray:
    """z along time, exact for piecewise linear q; holds outside motion have slid fully, z = sign(v), and so has what
    begins to move, which came from where it then goes, unless a start is given.
    """
    step = np.diff(data.q[:, axis], prepend=data.q[0, axis])
    keep = np.exp(-np.abs(step) / max(travel, 1e-12))
    target = np.sign(step)
    moving, hold = data.is_motion & ~data.begins_motion, data.direction[:, axis]
    hold = np.where(data.begins_motion, next_told(hold) if start is None else start, hold)
    gain = np.where(moving, keep, 0.0)
    return after_lines(float(hold[0]), gain, np.where(moving, target * (1.0 - keep), hold))
