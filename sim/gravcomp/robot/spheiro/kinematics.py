"""Closed-form kinematics of the 3-CPU spherical parallel robot.

Frame: origin O, the cylindrical joint axes e_1, e_2, e_3 are x, y, z. A pose is the rotation R of the platform;
leg i ends at the universal joint P_i = d R u_i, with u_1 = y, u_2 = z, u_3 = x at home. Its motor coordinate is
q_i = e_i . P_i. Every function is vectorised over leading axes of poses.

Source: Callegari et al. (2004) for the mechanism; the direct kinematics is the closed form of the project's design:
the squared quaternion parts of M = R U0 are the barycentric coordinates of q in the tetrahedron whose faces are the
singular surfaces.
"""

import numpy as np

from gravcomp.robot.protocol import PoseError
from gravcomp.robot.spheiro.parameters import RobotParameters

# Columns u_1 = y, u_2 = z, u_3 = x: directions of the universal joints at home.
HOME_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

# Squared quaternion parts (w, x, y, z) of M are (1 + SIGNS q/d)/4: one row per vertex of the joint-space tetrahedron.
_SIGNS = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])

# Below this barycentric coordinate (0.25 at home) a pose counts as singular: the Jacobian loses more than six digits.
SINGULAR_MARGIN = 1e-12
_ORTHONORMAL_TOLERANCE = 1e-9


def inverse_kinematics(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Motor positions q_i = d e_i . (R u_i), zero at home.

    rotation: (..., 3, 3), platform to base. Returns (..., 3), m. Raises PoseError.
    """
    return p.d_m * np.einsum("...ii->...i", platform_axes(rotation))


def direct_kinematics(q_m: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Rotation of the platform at motor positions q, in the home assembly mode (all four roots positive).

    q_m: (..., 3), m. Returns (..., 3, 3), platform to base. Raises PoseError.
    """
    q_m = np.asarray(q_m, dtype=float)
    if q_m.shape[-1:] != (3,):
        raise PoseError(f"joint positions have shape {q_m.shape}; give (..., 3)")
    _refuse(~np.isfinite(q_m).all(axis=-1), "is not a number; give finite joint positions in m")
    squares = quaternion_squares(q_m, p)
    _refuse_singular(squares.min(axis=-1))
    return axes_from_squares(squares) @ HOME_AXES.T


def quaternion_squares(q_m: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Squares (w^2, x^2, y^2, z^2) of the quaternion of M = R U0: barycentric coordinates of q, all positive inside.

    q_m: (..., 3), m, any number type. Returns (..., 4); no checks.
    """
    return (1.0 + (q_m / p.d_m) @ _SIGNS.T) / 4.0


def axes_from_squares(squares: np.ndarray) -> np.ndarray:
    """Matrix M = R U0 from the squares (w^2, x^2, y^2, z^2) of its quaternion, all roots positive.

    squares: (..., 4). Returns (..., 3, 3), columns R u_i.
    """
    root = np.sqrt(squares)
    w, x, y, z = (root[..., k] for k in range(4))
    ww, xx, yy, zz = (squares[..., k] for k in range(4))
    m = [
        [ww + xx - yy - zz, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), ww - xx + yy - zz, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), ww - xx - yy + zz],
    ]
    return np.stack([np.stack(row, axis=-1) for row in m], axis=-2)


def platform_axes(rotation: np.ndarray) -> np.ndarray:
    """Directions R u_i of the three universal joints from O, as the columns of (..., 3, 3).

    Raises PoseError when the pose is not a rotation, or at or beyond a singular face (another assembly mode).
    """
    rotation = np.asarray(rotation, dtype=float)
    if rotation.shape[-2:] != (3, 3):
        raise PoseError(f"rotations have shape {rotation.shape}; give (..., 3, 3)")
    _refuse(~np.isfinite(rotation).all(axis=(-2, -1)), "is not a number; give finite rotation matrices")
    defect = np.abs(rotation @ np.swapaxes(rotation, -1, -2) - np.eye(3)).max(axis=(-2, -1))
    is_improper = (defect > _ORTHONORMAL_TOLERANCE) | (np.linalg.det(rotation) < 0)
    _refuse(is_improper, "is not a rotation; give orthonormal matrices with determinant +1")
    m = rotation @ HOME_AXES
    # 4 w (x, y, z) of the quaternion of M: all positive exactly inside the home assembly mode.
    products = np.stack(
        [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], axis=-1
    )
    squares = (1.0 + np.einsum("...ii->...i", m) @ _SIGNS.T) / 4.0
    _refuse_singular(np.where((products > 0).all(axis=-1), squares.min(axis=-1), -1.0))
    return m


def jacobian(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Jacobian J of dq = J dtheta, rows d (R u_i x e_i); dtheta is a small rotation in the base frame.

    rotation: (..., 3, 3). Returns (..., 3, 3), m/rad. Raises PoseError.
    """
    points = p.d_m * np.swapaxes(platform_axes(rotation), -1, -2)
    return np.cross(points, np.eye(3))


def link_axes(points_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Length b_i and direction w_i of link 2 from the universal joints P_i.

    b_i = |P_i - q_i e_i|, w_i = (P_i - q_i e_i)/b_i. points_m: (..., 3, 3), row i is P_i, m.
    Returns b (..., 3), m, and w (..., 3, 3), row i is w_i.
    """
    across = points_m * (1.0 - np.eye(3))
    b = np.sqrt((across * across).sum(axis=-1))
    return b, across / b[..., None]


def passive_coordinates(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Passive joint coordinates (b_1, b_2, b_3, phi_1, phi_2, phi_3).

    b_i: prismatic, m, equal to d at home. phi_i: rotation of leg i about +e_i, rad, zero at home.
    rotation: (..., 3, 3). Returns (..., 6). Raises PoseError.
    """
    b, w = link_axes(p.d_m * np.swapaxes(platform_axes(rotation), -1, -2))
    w_home = HOME_AXES.T
    phi = np.arctan2((w * np.cross(np.eye(3), w_home)).sum(axis=-1), (w * w_home).sum(axis=-1))
    return np.concatenate([b, phi], axis=-1)


def passive_jacobian(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Jacobian J_p of the passive joints, d(b, phi) = J_p dq.

    db_i = w_i . dP_i and dphi_i = t_i . dP_i / b_i with t_i = e_i x w_i, dP_i = dtheta x P_i, dtheta = J^-1 dq.
    rotation: (..., 3, 3). Returns (..., 6, 3); rows 0..2 in m/m, rows 3..5 in rad/m. Raises PoseError.
    """
    points = p.d_m * np.swapaxes(platform_axes(rotation), -1, -2)
    b, w = link_axes(points)
    t = np.cross(np.eye(3), w)
    by_rotation = np.concatenate([np.cross(points, w), np.cross(points, t) / b[..., None]], axis=-2)
    return by_rotation @ np.linalg.inv(np.cross(points, np.eye(3)))


def universal_angles(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Angles of the universal joints' hinges (inner_1, .., inner_3, outer_1, .., outer_3), rad, zero at home.

    Leg i turns about e_i, then the inner hinge about t_i = e_i x w_i, then the outer one about a_i = R u_i, which is
    fixed in the platform: tan(inner_i) = -q_i/b_i, and outer_i turns t_i into R (e_i x u_i).
    rotation: (..., 3, 3). Returns (..., 6). Raises PoseError.
    """
    a = np.swapaxes(platform_axes(rotation), -1, -2)
    b, w = link_axes(p.d_m * a)
    t, across = np.cross(np.eye(3), w), np.cross(np.eye(3), HOME_AXES.T) @ np.swapaxes(rotation, -1, -2)
    inner = np.arctan2(-inverse_kinematics(rotation, p), b)
    outer = np.arctan2((np.cross(a, t) * across).sum(axis=-1), (t * across).sum(axis=-1))
    return np.concatenate([inner, outer], axis=-1)


def universal_jacobian(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Jacobian J_u of the universal joints' hinges, d(inner, outer) = J_u dq.

    dinner_i = t_i . dtheta and douter_i = (d/b_i) w_i . dtheta, dtheta = J^-1 dq.
    rotation: (..., 3, 3). Returns (..., 6, 3), rad/m. Raises PoseError.
    """
    points = p.d_m * np.swapaxes(platform_axes(rotation), -1, -2)
    b, w = link_axes(points)
    by_rotation = np.concatenate([np.cross(np.eye(3), w), p.d_m / b[..., None] * w], axis=-2)
    return by_rotation @ np.linalg.inv(np.cross(points, np.eye(3)))


def _refuse_singular(margin: np.ndarray) -> None:
    _refuse(margin <= SINGULAR_MARGIN, "is at or beyond a singular face of the joint space; stay inside it")


def _refuse(is_bad: np.ndarray, why: str) -> None:
    bad = np.flatnonzero(np.atleast_1d(is_bad))
    if bad.size:
        more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
        raise PoseError(f"pose {bad[0]}{more} {why}", int(bad[0]))
