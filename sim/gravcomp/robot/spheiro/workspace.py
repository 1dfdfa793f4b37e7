"""Poses of the workspace: R = Rot(tilt about an axis perpendicular to n) Rot(torsion about n), n = (1,1,1)/sqrt(3)."""

import numpy as np

from gravcomp.robot.spheiro.parameters import RobotParameters

CENTRE = np.ones(3) / np.sqrt(3.0)
# Azimuth 0 tilts about the first of these axes, azimuth 90 deg about the second; they form a right-handed frame with n.
_TILT_AXES = np.array([[1.0, -1.0, 0.0] / np.sqrt(2.0), [1.0, 1.0, -2.0] / np.sqrt(6.0)])


def pose(azimuth_rad: np.ndarray, tilt_rad: np.ndarray, torsion_rad: np.ndarray) -> np.ndarray:
    """Rotation of the platform from azimuth and size of its tilt and its torsion about n.

    All arguments broadcast to a common shape (...), rad, of any number type that has sine and cosine. Returns
    (..., 3, 3), platform to base.
    """
    azimuth, tilt, torsion = np.broadcast_arrays(azimuth_rad, tilt_rad, torsion_rad)
    direction = np.cos(azimuth)[..., None] * _TILT_AXES[0] + np.sin(azimuth)[..., None] * _TILT_AXES[1]
    return _turn(direction, tilt) @ _turn(CENTRE, torsion)


def angles_of(rotation: np.ndarray) -> np.ndarray:
    """Azimuth, tilt and torsion (..., 3), rad, of rotations (..., 3, 3): what `pose` makes them of.

    Azimuth within -pi and pi, tilt within 0 and pi; without a tilt the azimuth is any, as rounding has it.
    """
    towards = rotation @ CENTRE  # n, tilted
    across = np.cross(CENTRE, towards)  # sin(tilt) times the axis of the tilt
    tilt = np.arctan2(np.linalg.norm(across, axis=-1), towards @ CENTRE)
    azimuth = np.arctan2(across @ _TILT_AXES[1], across @ _TILT_AXES[0])
    twisted = np.swapaxes(pose(azimuth, tilt, 0.0), -1, -2) @ rotation @ _TILT_AXES[0]
    return np.stack([azimuth, tilt, np.arctan2(twisted @ _TILT_AXES[1], twisted @ _TILT_AXES[0])], axis=-1)


def _turn(direction: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (..., 3, 3) about unit vectors (..., 3) by angles (...): Rodrigues' formula."""
    cosine, sine = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    along = direction[..., :, None] * direction[..., None, :]
    across = np.cross(np.eye(3), direction[..., None, :])  # the matrix of v -> direction x v
    return cosine * np.eye(3) + (1.0 - cosine) * along + sine * across


def sample_boundary(n_poses: int, p: RobotParameters, seed: int) -> np.ndarray:
    """Random poses (n_poses, 3, 3) of the workspace's boundary: a third each of the largest tilt, of either torsion,
    and of both, where a network errs most.
    """
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0.0, 2.0 * np.pi, n_poses)
    tilt = np.deg2rad(rng.uniform(0.0, p.tilt_max_deg, n_poses))
    torsion = np.deg2rad(rng.uniform(-p.torsion_max_deg, p.torsion_max_deg, n_poses))
    part = rng.integers(3, size=n_poses)
    tilt = np.where(part != 1, np.deg2rad(p.tilt_max_deg), tilt)
    return pose(azimuth, tilt, np.where(part != 0, np.copysign(np.deg2rad(p.torsion_max_deg), torsion), torsion))


def sample_workspace(
    n_poses: int,
    p: RobotParameters,
    seed: int,
    *,
    torsion_deg: float | None = None,
    tilt_max_deg: float | None = None,
) -> np.ndarray:
    """Random poses of the workspace: azimuth, tilt and torsion uniform, so poses are denser near home.

    seed: of numpy's default generator. torsion_deg: hold the torsion at this value. tilt_max_deg: a smaller cone
    (default: the workspace's). Returns (n_poses, 3, 3), platform to base.
    """
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0.0, 2.0 * np.pi, n_poses)
    tilt = np.deg2rad(rng.uniform(0.0, p.tilt_max_deg if tilt_max_deg is None else tilt_max_deg, n_poses))
    torsion = np.deg2rad(rng.uniform(-p.torsion_max_deg, p.torsion_max_deg, n_poses))
    if torsion_deg is not None:
        torsion = np.full(n_poses, np.deg2rad(torsion_deg))
    return pose(azimuth, tilt, torsion)
