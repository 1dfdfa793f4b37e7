"""Normalisation of joint positions and efforts, per axis, from the ranges of the axes and the bounds of the workspace.

The hardware clamps x to [-1, 1), so the ranges must hold every pose of the workspace, not only a sample.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.machine import Machine


@dataclass(frozen=True)
class Scaling:
    """x = (q - q_offset) q_scale and y = (f - f_offset) / f_scale, (n,) each: |x| < 1, |y| <= 1 in the workspace."""

    q_offset: np.ndarray
    q_scale: np.ndarray
    f_offset: np.ndarray
    f_scale: np.ndarray
    position_units: tuple[str, ...]

    @property
    def is_uniform(self) -> bool:
        """Whether all axes have the same scaling, which a symmetry of the robot survives."""
        return all(len(set(values)) == 1 for values in vars(self).values())

    def x(self, q: np.ndarray) -> np.ndarray:
        return (q - self.q_offset) * self.q_scale

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
    # An axis without load keeps the scale of the others.
    half = (bounds.f_high - bounds.f_low) / 2.0
    f_scale = np.where(half > 0, half, half.max() if half.max() > 0 else 1.0)
    return Scaling(
        (high + low) / 2.0, 2.0 / (high - low), (bounds.f_high + bounds.f_low) / 2.0, f_scale, machine.position_units
    )
