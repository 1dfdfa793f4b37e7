"""Normalisation of joint positions and forces, from the bounds of the whole workspace.

The hardware clamps x to [-1, 1), so the bounds must hold for every pose of the workspace, not only for a sample.
One scaling serves all axes: the robot's symmetry then survives it.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.statics import holding_forces
from gravcomp.robot.spheiro.workspace import pose

# Bounds come from a grid and are rounded outward to these; a bound between
# two grid points is less than 0.01 mm and 0.05 N beyond them.
_Q_STEP_M, _F_STEP_N = 1e-3, 1.0
_GRID = (361, 15, 41)  # azimuth, tilt, torsion; their corners included


@dataclass(frozen=True)
class Scaling:
    """x = q q_scale_per_m and y = (f - f_offset_n) / f_scale_n for every axis: |x| < 1, |y| <= 1 in the workspace."""

    q_scale_per_m: float
    f_offset_n: float
    f_scale_n: float

    def x(self, q_m: np.ndarray) -> np.ndarray:
        return q_m * self.q_scale_per_m

    def y(self, f_n: np.ndarray) -> np.ndarray:
        return (f_n - self.f_offset_n) / self.f_scale_n


def workspace_scaling(p: RobotParameters) -> Scaling:
    """The scaling that spans the workspace's tilt and torsion box. Raises PoseError when the box leaves the robot's."""
    azimuth = np.linspace(0.0, 2.0 * np.pi, _GRID[0])[:, None, None]
    tilt = np.deg2rad(np.linspace(0.0, p.tilt_max_deg, _GRID[1]))[:, None]
    torsion = np.deg2rad(np.linspace(-p.torsion_max_deg, p.torsion_max_deg, _GRID[2]))
    rotation = pose(azimuth, tilt, torsion)
    q_m, f_n = inverse_kinematics(rotation, p), holding_forces(rotation, p)
    q_limit_m = (np.floor(np.abs(q_m).max() / _Q_STEP_M) + 1.0) * _Q_STEP_M
    f_low_n = np.floor(f_n.min() / _F_STEP_N) * _F_STEP_N
    f_high_n = np.ceil(f_n.max() / _F_STEP_N) * _F_STEP_N
    f_scale_n = max((f_high_n - f_low_n) / 2.0, _F_STEP_N)
    return Scaling(float(1.0 / q_limit_m), float((f_high_n + f_low_n) / 2.0), float(f_scale_n))
