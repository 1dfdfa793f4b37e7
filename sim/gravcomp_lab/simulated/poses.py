"""The poses that the core is judged on: four sets, as the paper judges it, and one continuous motion."""

import numpy as np

from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp.robot.spheiro.workspace import pose, sample_workspace

NEAR_HOME_DEG = 10.0
SETS = {
    f"near home (tilt < {NEAR_HOME_DEG:.0f} deg)": {"tilt_max_deg": NEAR_HOME_DEG},
    "whole workspace": {},
    "torsion 0 deg": {"torsion_deg": 0.0},
    "torsion 15 deg": {"torsion_deg": 15.0},
}
SEED = 20
POSES_PER_SET = 150


def pose_sets(machine: Machine) -> dict[str, np.ndarray]:
    """Encoder counts (POSES_PER_SET, 3) of each set, drawn with SEED and its successors."""
    return {
        name: counts_at(sample_workspace(POSES_PER_SET, spheiro_of(machine), SEED + k, **limits), machine)
        for k, (name, limits) in enumerate(SETS.items())
    }


def motion(machine: Machine, n_poses: int, start_s: float = 0.0, period_s: float = 1e-3) -> np.ndarray:
    """Encoder counts (n_poses, 3) every period_s, from start_s on, of a smooth motion that starts at rest at home.

    The tilt swings out and back to 20 deg while its azimuth turns and the torsion swings: all axes reverse.
    """
    t = start_s + np.arange(n_poses) * period_s
    tilt = np.deg2rad(10.0) * (1 - np.cos(2 * np.pi * 0.5 * t))
    return counts_at(pose(2 * np.pi * 0.4 * t, tilt, np.deg2rad(8.0) * np.sin(2 * np.pi * 0.7 * t)), machine)


def counts_at(rotation: np.ndarray, machine: Machine) -> np.ndarray:
    """Encoder counts (..., 3) at poses (..., 3, 3): q over the encoder's step, rounded."""
    return machine.drive.counts(inverse_kinematics(rotation, spheiro_of(machine)))
