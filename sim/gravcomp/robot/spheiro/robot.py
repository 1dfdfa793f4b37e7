"""The Sphe.I.Ro. as a Robot: three linear axes, forces in closed form."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.machine import Machine
from gravcomp.robot.protocol import Bounds, Formula, PoseError
from gravcomp.robot.spheiro.kinematics import (
    HOME_AXES,
    direct_kinematics,
    inverse_kinematics,
    passive_jacobian,
    universal_angles,
    universal_jacobian,
)
from gravcomp.robot.spheiro.parameters import RobotParameters, parameters_from_table
from gravcomp.robot.spheiro.reactions import slide_reactions
from gravcomp.robot.spheiro.statics import forces_from_axes, holding_forces, holding_forces_at
from gravcomp.robot.spheiro.workspace import angles_of, pose, sample_boundary, sample_workspace

# Bounds come from a grid and are rounded outward to these; a bound between
# two grid points is less than 0.01 mm and 0.05 N beyond them.
_Q_STEP_M, _F_STEP_N = 1e-3, 1.0
_ROUNDING_DEG = 1e-9  # of an angle that was given in degrees
_GRID = (361, 15, 41)  # azimuth, tilt, torsion; their corners included


@dataclass(frozen=True)
class Spheiro:
    """The robot with its parameters."""

    parameters: RobotParameters

    n_axes = 3
    position_units = ("m",) * 3
    passive_units = ("m",) * 3 + ("rad",) * 3  # b_1..3, then phi_1..3
    # The paper's alpha, beta and gamma: direction of the tilt around the base circle, size of the tilt, torsion.
    orientation_names = ("elevation", "azimuth", "torsion")

    def forces(self, q: np.ndarray) -> np.ndarray:
        """Forces (..., 3), N, at q (..., 3), m. Raises PoseError outside the joint space."""
        return holding_forces_at(q, self.parameters)

    def workspace(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, 3), m, of poses whose azimuth, tilt and torsion are uniform."""
        return inverse_kinematics(sample_workspace(n_poses, self.parameters, seed), self.parameters)

    def boundary(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, 3), m, of poses with the largest tilt or torsion."""
        return inverse_kinematics(sample_boundary(n_poses, self.parameters, seed), self.parameters)

    def at_orientation(self, angles_rad: np.ndarray) -> np.ndarray:
        """Positions (..., 3), m, at elevation, azimuth and torsion (..., 3), rad: what `pose` calls azimuth, tilt and
        torsion. Raises PoseError outside the workspace.
        """
        p, angles = self.parameters, np.asarray(angles_rad, dtype=float)
        tilt, torsion = np.rad2deg(angles[..., 1]), np.abs(np.rad2deg(angles[..., 2]))
        largest = np.maximum(tilt - p.tilt_max_deg, torsion - p.torsion_max_deg)
        is_inside = np.isfinite(angles).all(axis=-1) & (np.maximum(largest, -tilt) <= _ROUNDING_DEG)
        if bad := np.flatnonzero(~np.atleast_1d(is_inside)).tolist():
            mend = (
                f"an azimuth from 0 to {p.tilt_max_deg:g}, a torsion of {p.torsion_max_deg:g} deg at most, either way"
            )
            raise PoseError(f"pose {bad[0] + 1} is outside the workspace; give {mend}", bad[0])
        return inverse_kinematics(pose(*np.moveaxis(angles, -1, 0)), p)

    def orientation(self, q: np.ndarray) -> np.ndarray:
        """Elevation, azimuth and torsion (..., 3), rad, at positions (..., 3), m. Raises PoseError outside the joint
        space.
        """
        return angles_of(direct_kinematics(q, self.parameters))

    @cached_property
    def bounds(self) -> Bounds:
        """The same for all axes: a symmetry survives it. Raises PoseError when the workspace leaves the robot's."""
        p = self.parameters
        azimuth = np.linspace(0.0, 2.0 * np.pi, _GRID[0])[:, None, None]
        tilt = np.deg2rad(np.linspace(0.0, p.tilt_max_deg, _GRID[1]))[:, None]
        torsion = np.deg2rad(np.linspace(-p.torsion_max_deg, p.torsion_max_deg, _GRID[2]))
        rotation = pose(azimuth, tilt, torsion)
        q_m, f_n = inverse_kinematics(rotation, p), holding_forces(rotation, p)
        reach_m, each = np.abs(q_m).max(), np.ones(3)
        limit_m = (np.floor(reach_m / _Q_STEP_M) + 1.0) * _Q_STEP_M
        low_n = np.floor(f_n.min() / _F_STEP_N) * _F_STEP_N
        high_n = np.ceil(f_n.max() / _F_STEP_N) * _F_STEP_N
        return Bounds(-limit_m * each, limit_m * each, -reach_m * each, reach_m * each, low_n * each, high_n * each)

    @property
    def gravity_direction(self) -> np.ndarray:
        return self.parameters.gravity_direction

    def with_gravity(self, direction: np.ndarray) -> "Spheiro":
        return Spheiro(replace(self.parameters, gravity_direction=direction))

    def payload_regressors(self, q: np.ndarray) -> np.ndarray:
        """Forces (..., 3, 3), N, per kg m of first moment in the platform frame."""
        massless = {f"{body}_mass_kg": 0.0 for body in ("carriage", "link1", "link2")}
        bare = replace(self.parameters, **massless, platform_mass_kg=1.0)
        return np.stack([holding_forces_at(q, replace(bare, platform_com_m=unit)) for unit in np.eye(3)], axis=-1)

    def passive_jacobian(self, q: np.ndarray) -> np.ndarray:
        return passive_jacobian(direct_kinematics(q, self.parameters), self.parameters)

    def slide_reactions(self, q: np.ndarray) -> np.ndarray:
        return slide_reactions(direct_kinematics(q, self.parameters), self.parameters)

    def universal_angles(self, q: np.ndarray) -> np.ndarray:
        return universal_angles(direct_kinematics(q, self.parameters), self.parameters)

    def universal_jacobian(self, q: np.ndarray) -> np.ndarray:
        return universal_jacobian(direct_kinematics(q, self.parameters), self.parameters)

    def formula(self) -> Formula:
        """Over azimuth, tilt and torsion: the workspace is a box of them."""
        p = self.parameters
        tilt, torsion = np.deg2rad(p.tilt_max_deg), np.deg2rad(p.torsion_max_deg)

        def at(parameters):
            axes = pose(*np.moveaxis(parameters, -1, 0)) @ HOME_AXES
            return p.d_m * np.diagonal(axes, axis1=-2, axis2=-1), forces_from_axes(axes, p)

        low, high = np.array([0.0, 0.0, -torsion]), np.array([2.0 * np.pi, tilt, torsion])
        return Formula(("azimuth_rad", "tilt_rad", "torsion_rad"), low, high, at)


def spheiro_of(machine: Machine) -> RobotParameters:
    """The parameters of a machine of this kind. Raises InputError for another one."""
    if not isinstance(machine.robot, Spheiro):
        raise InputError(f'{machine.where}: needs [model] kind = "spheiro"; this works with that robot alone')
    return machine.robot.parameters


def from_table(table: dict, where: str) -> Spheiro:
    """The robot of a robot.toml. Raises InputError naming table and key."""
    kind = table.get("workspace", {}).get("kind") if isinstance(table.get("workspace"), dict) else None
    if kind != "spheiro":
        raise InputError(f'{where}: [workspace] kind = {kind!r}; this robot has its own, give kind = "spheiro"')
    return Spheiro(parameters_from_table(table, where))
