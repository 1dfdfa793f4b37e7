"""Holding forces of the robot at rest, by virtual work.

f = J^-T dU/dtheta, with U the potential energy of all bodies. f_i is the force that motor i exerts, positive along
+q_i, to hold the robot. The gradient is analytic: a body at r = c + l w_i turns and slides with its leg, so each of
its terms is a cross product with a vector known in closed form.
"""

import numpy as np

from gravcomp.robot.spheiro.kinematics import direct_kinematics, link_axes, platform_axes
from gravcomp.robot.spheiro.parameters import RobotParameters


def potential_energy(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Potential energy of all bodies, J, zero at O: U = -sum m g . r.

    rotation: (..., 3, 3), platform to base. Returns (...). Raises PoseError.
    """
    points = p.d_m * np.swapaxes(platform_axes(rotation), -1, -2)
    _, w = link_axes(points)
    carriage = points * np.eye(3)  # row i is q_i e_i
    moment = (
        p.carriage_mass_kg * carriage
        + p.link1_mass_kg * (carriage + p.link1_com_m * w)
        + p.link2_mass_kg * (points - p.link2_com_m * w)
    ).sum(axis=-2) + p.platform_mass_kg * np.asarray(rotation) @ p.platform_com_m
    return -(moment @ p.gravity_mps2)


def holding_forces(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Motor forces that hold the robot at rest at pose R.

    rotation: (..., 3, 3), platform to base. Returns (..., 3), N, positive along +q_i. Raises PoseError.
    """
    return forces_from_axes(platform_axes(rotation), p)


def holding_forces_at(q_m: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Motor forces that hold the robot at rest at motor positions q, home assembly mode.

    q_m: (..., 3), m. Returns (..., 3), N, positive along +q_i. Raises PoseError.
    """
    return holding_forces(direct_kinematics(q_m, p), p)


def forces_from_axes(axes: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Holding forces from the directions R u_i (columns of axes, (..., 3, 3)); no checks, any number type.

    With P_i = d R u_i, t_i = e_i x w_i and a = -g:
    dU/dtheta = sum_i [(m0 + m1) (e_i.a) (P_i x e_i) + m2 (P_i x a) + (m1 c1 - m2 c2)(t_i.a)/b_i (P_i x t_i)]
                + mp (R r_c) x a.
    Solving J^T f = dU/dtheta by Cramer's rule keeps the whole path closed form. Returns (..., 3), N.
    """
    lift = -p.gravity_mps2
    points = p.d_m * np.swapaxes(axes, -1, -2)
    b, w = link_axes(points)
    t = np.cross(np.eye(3), w)
    rows = np.cross(points, np.eye(3))  # the Jacobian
    swing = (p.link1_mass_kg * p.link1_com_m - p.link2_mass_kg * p.link2_com_m) * (t * lift).sum(axis=-1) / b
    # R r_c = M (U0^T r_c); U0 only permutes the axes.
    platform = (axes * p.platform_com_m[[1, 2, 0]]).sum(axis=-1)
    lever = p.link2_mass_kg * points.sum(axis=-2) + p.platform_mass_kg * platform
    gradient = (
        (rows * ((p.carriage_mass_kg + p.link1_mass_kg) * lift)[:, None]).sum(axis=-2)
        + (np.cross(points, t) * swing[..., None]).sum(axis=-2)
        + np.cross(lever, lift)
    )
    return _solve_transposed(rows, gradient)


def _solve_transposed(rows: np.ndarray, rhs: np.ndarray) -> np.ndarray:
    """Solve sum_i f_i rows_i = rhs: f_i = rhs . (rows_j x rows_k) / det."""
    cofactors = np.stack([np.cross(rows[..., (i + 1) % 3, :], rows[..., (i + 2) % 3, :]) for i in range(3)], axis=-2)
    determinant = (rows[..., 0, :] * cofactors[..., 0, :]).sum(axis=-1, keepdims=True)
    return (cofactors * rhs[..., None, :]).sum(axis=-1) / determinant
