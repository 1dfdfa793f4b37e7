"""The effort has another level from one moment on: a part came off, a zero has jumped."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, Variable, by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, held_out_about, needs_time
from gravcomp.diagnosis.search.periodogram import step_in


class OffsetStep(Effect):
    """step_i for t > t_step."""

    name = "offset_step"
    equation = "step_i for t > t_step"
    hardware = "none"
    units = {"step": "[f]", "t_step": "s"}  # noqa: RUF012
    complexity = "rarer"
    is_scanned = True

    unavailable = staticmethod(needs_time)

    def shapes(self, data):
        return []

    def scanned_shapes(self, data, rows, residual):
        """The moment at which each axis alone, and all together, most clearly change their level."""
        t = data.t_s[rows]
        found = {step_in(t, own) for own in residual.T}
        size = residual.std(axis=0)
        jumps = np.sign([np.mean(own[t > step_in(t, own)]) for own in residual.T])
        found.add(step_in(t, (residual / np.where(size > 0.0, size, 1.0)) @ jumps))
        return {((Parameter("t_step_s"), float(at)),) for at in found}

    def columns(self, data, shape):
        late = (data.t_s > shape["t_step_s"]).astype(float)
        return by_axis(data, "step", np.repeat(late[:, None], data.n_axes, axis=1))

    def unseen(self, data, parameters, is_test):
        rows = held_out_about(data, parameters["t_step_s"], is_test)
        return rows[:, None] & (per_axis(parameters, "step", data.n_axes) != 0.0)

    def follows(self, data, parameters, force):
        return [(int(axis), Variable("t")) for axis in np.flatnonzero(force.any(axis=0))]
