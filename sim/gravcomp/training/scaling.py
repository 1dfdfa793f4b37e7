"""Normalisation of joint positions and efforts, per axis, from the ranges of the axes and the bounds of the workspace.

The hardware clamps x to [-1, 1), so the ranges must hold every pose of the workspace, not only a sample.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.errors import InputError
from gravcomp.network.inputs import POSITION, SIN_COS, inputs_of
from gravcomp.robot.machine import Machine

_LEAST_SHARE = 1.0 / 64.0  # of the largest scale of efforts: all have one format in hardware
_OFFSET_SHARE = 1.0 / 4.0  # of an offset: one format holds y with it, and bits for a large one are lost to all axes


@dataclass(frozen=True)
class Scaling:
    """x = (q - q_offset) q_scale, or sin and cos, and y = (f - f_offset) / f_scale: at most 1 in the workspace.

    (n,) each; inputs: position or sin_cos by axis.
    """

    q_offset: np.ndarray
    q_scale: np.ndarray
    f_offset: np.ndarray
    f_scale: np.ndarray
    position_units: tuple[str, ...]
    inputs: tuple[str, ...] = ()

    @property
    def is_uniform(self) -> bool:
        """Whether all axes have the same scaling, which a symmetry of the robot survives."""
        return all(len(set(values)) == 1 for values in vars(self).values())

    def x(self, q: np.ndarray) -> np.ndarray:
        return inputs_of(q, self.q_offset, self.q_scale, self.inputs or (POSITION,) * len(self.q_scale))

    def y(self, f: np.ndarray) -> np.ndarray:
        return (f - self.f_offset) / self.f_scale


def workspace_scaling(machine: Machine) -> Scaling:
    """The scaling that spans the ranges of the axes. Raises InputError when the workspace leaves them."""
    bounds = machine.robot.bounds
    low, high = (np.array([getattr(axis, end) for axis in machine.axes]) for end in ("low", "high"))
    for k in np.flatnonzero((low > bounds.q_least) | (high < bounds.q_most)):
        raise InputError(
            f"{machine.where}: axis {k + 1}: low .. high = {low[k]:g} .. {high[k]:g} is narrower than the workspace, "
            f"which reaches from {bounds.q_least[k]:.6g} to {bounds.q_most[k]:.6g} {machine.axes[k].unit}; widen it, "
            "or make [workspace] smaller"
        )
    half, middle = (bounds.f_high - bounds.f_low) / 2.0, (bounds.f_high + bounds.f_low) / 2.0
    turns = np.array([kind == SIN_COS for kind in machine.inputs])
    return Scaling(
        q_offset=np.where(turns, 0.0, (high + low) / 2.0),
        q_scale=np.where(turns, 1.0, 2.0 / (high - low)),
        f_offset=middle,
        f_scale=effort_scale(half, middle, machine.position_units),
        position_units=machine.position_units,
        inputs=machine.inputs,
    )


def effort_scale(half: np.ndarray, middle: np.ndarray, units: tuple[str, ...]) -> np.ndarray:
    """One scale per unit: an N or N m counts the same on every axis, so that the RMS error over all of them is least.

    half, middle (n,): of the range of efforts. Where nothing in a unit bears a load the scale is 1, or what the common
    format of all scales can hold.
    """
    half = np.maximum(half, _OFFSET_SHARE * np.abs(middle))
    largest = {unit: max(h for h, own in zip(half, units, strict=True) if own == unit) for unit in units}
    least = _LEAST_SHARE * max(largest.values())
    return np.array([max(largest[unit], least) or 1.0 for unit in units])
