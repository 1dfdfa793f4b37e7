"""Play between encoder and joint: the joint lags by half the gap."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_function, needs_velocity
from gravcomp.diagnosis.running import after_clips, next_told


class Backlash(Effect):
    """f_model(q - gap/2 z) - f_model(q) with z = sign(v); with a travel, z takes it to change sign in motion."""

    name = "backlash"
    driver = "dir"
    equation = "f_model(q - gap/2 sign(v)) - f_model(q)"
    hardware = "none"
    units = {"gap": "[q]", "travel": "[q]"}  # noqa: RUF012
    positive = ("gap",)
    per_axis = False
    is_curved = True
    complexity = "uncommon"

    def unavailable(self, data):
        return needs_velocity(data) or needs_function(data)

    def groups(self, labels):
        return [{label} for label in labels]

    def columns(self, data, shape):
        lag = -0.5 * data.sensitivity * _side(data, shape)[:, None, :]
        return {Parameter("gap", j): lag[..., j] for j in range(data.n_axes)}

    def predict(self, data, parameters):
        gap = per_axis(parameters, "gap", data.n_axes)
        return data.force_at(data.q - 0.5 * gap * _side(data, parameters)) - data.modelled


class BacklashInMotion(Backlash):
    """Backlash of which the data shows the travel: the encoder crosses the gap before the joint follows."""

    complexity = "rarer"
    scales = ("travel",)

    def unavailable(self, data):
        return super().unavailable(data) or ("" if data.is_motion.mean() > 0.3 else "no motion along time")

    def shapes(self, data):
        stroke = np.ptp(data.q, axis=0)
        fractions = (0.01, 0.02, 0.03, 0.045, 0.06, 0.08)
        return [{Parameter("travel", j): f * stroke[j] for j in range(data.n_axes)} for f in fractions]

    def doubt(self, data, parameters):
        """On which side of its gap a joint began to move is not told until it has crossed the gap."""
        gap = per_axis(parameters, "gap", data.n_axes)
        up, down = (_side(data, parameters, start) for start in (1.0, -1.0))
        return np.einsum("nij,nj->ni", np.abs(data.sensitivity), 0.5 * gap * (up - down))


def _side(data, parameters, start: float | None = None) -> np.ndarray:
    """z (n, k), -1..1: on which side of its gap each joint is; one that begins to move is as if it had moved before,
    unless a start is given.
    """
    side = data.direction.copy()
    for j in range(data.n_axes):
        if Parameter("travel", j) in parameters:
            side[:, j] = _crossing(data, j, parameters[Parameter("travel", j)], start)
    return side


def _crossing(data, axis: int, travel: float, start: float | None) -> np.ndarray:
    """z along time, the play operator: dz = 2 dq/travel within -1..1. Holds were approached over more than the gap; a
    motion that begins at rest came from where it then goes.
    """
    step = 2.0 * np.diff(data.q[:, axis], prepend=data.q[0, axis]) / max(travel, 1e-12)
    moving, hold = data.is_motion & ~data.begins_motion, data.direction[:, axis]
    hold = np.where(data.begins_motion, next_told(hold) if start is None else start, hold)
    shift, low, high = np.where(moving, step, 0.0), np.where(moving, -1.0, hold), np.where(moving, 1.0, hold)
    return after_clips(float(hold[0]), shift, low, high)
