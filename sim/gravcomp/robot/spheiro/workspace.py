"""Poses of the workspace: R = Rot(tilt about an axis perpendicular to n) Rot(torsion about n), n = (1,1,1)/sqrt(3)."""

import numpy as np
from scipy.spatial.transform import Rotation

from gravcomp.robot.spheiro.parameters import RobotParameters

CENTRE = np.ones(3) / np.sqrt(3.0)
# Azimuth 0 tilts about the first of these axes, azimuth 90 deg about the second; they form a right-handed frame with n.
_TILT_AXES = np.array([[1.0, -1.0, 0.0] / np.sqrt(2.0), [1.0, 1.0, -2.0] / np.sqrt(6.0)])


def pose(azimuth_rad: np.ndarray, tilt_rad: np.ndarray, torsion_rad: np.ndarray) -> np.ndarray:
    """Rotation of the platform from azimuth and size of its tilt and its torsion about n.

    All arguments broadcast to a common shape (...), rad. Returns (..., 3, 3), platform to base.
    """
    azimuth, tilt, torsion = np.broadcast_arrays(azimuth_rad, tilt_rad, torsion_rad)
    shape = azimuth.shape
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1) @ _TILT_AXES
    tilted = Rotation.from_rotvec((tilt[..., None] * direction).reshape(-1, 3))
    twisted = Rotation.from_rotvec((torsion[..., None] * CENTRE).reshape(-1, 3))
    return (tilted * twisted).as_matrix().reshape(*shape, 3, 3)


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
