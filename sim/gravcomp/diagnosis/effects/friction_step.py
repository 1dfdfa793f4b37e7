"""Friction that is another from one moment on: a brake that drags, a seal that seizes, grease that gives way."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, Variable, by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, held_out_about, needs_time, needs_velocity
from gravcomp.diagnosis.thresholds import STEP_EDGE


class FrictionStep(Effect):
    """step_i sign(v_i) for t > t_step."""

    name = "friction_step"
    equation = "step_i sign(v_i) for t > t_step"
    hardware = "none"
    units = {"step": "[f]", "t_step": "s"}  # noqa: RUF012
    complexity = "rarer"
    is_scanned = True

    def unavailable(self, data):
        return needs_velocity(data) or needs_time(data)

    def shapes(self, data):
        return []

    def scanned_shapes(self, data, rows, residual):
        """The moment at which the part of a residual that goes with the direction most clearly changes, on all axes
        together and on each.
        """
        n, edge = len(rows), max(int(STEP_EDGE * len(rows)), 2)
        if n < 4 * edge:
            return set()
        friction = residual * data.direction[rows]
        before = np.arange(1, n + 1)
        total = np.cumsum(friction - friction.mean(axis=0), axis=0)
        gain = total**2 / (before * np.maximum(n - before, 1))[:, None]
        clear = gain[edge:-edge]
        at = {edge + int(clear.sum(axis=1).argmax()), *(edge + clear.argmax(axis=0)).tolist()}
        t = data.t_s[rows]
        return {((Parameter("t_step_s"), float(0.5 * (t[k] + t[min(k + 1, n - 1)]))),) for k in at}

    def columns(self, data, shape):
        return by_axis(data, "step", (data.t_s > shape["t_step_s"])[:, None] * data.direction)

    def unseen(self, data, parameters, is_test):
        rows = held_out_about(data, parameters["t_step_s"], is_test)
        return rows[:, None] & (per_axis(parameters, "step", data.n_axes) != 0.0)

    def follows(self, data, parameters, force):
        return [(int(axis), Variable("t")) for axis in np.flatnonzero(force.any(axis=0))]
