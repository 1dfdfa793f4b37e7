"""The poses that the core is judged on, and one continuous motion: of the Sphe.I.Ro. four sets, as the paper judges it,
of any other robot its workspace."""

import numpy as np

from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.robot import Spheiro, spheiro_of
from gravcomp.robot.spheiro.workspace import pose, sample_workspace

NEAR_HOME_DEG = 10.0
WHOLE = "whole workspace"
SETS = {
    f"near home (tilt < {NEAR_HOME_DEG:.0f} deg)": {"tilt_max_deg": NEAR_HOME_DEG},
    WHOLE: {},
    "torsion 0 deg": {"torsion_deg": 0.0},
    "torsion 15 deg": {"torsion_deg": 15.0},
}
SEED = 20
POSES_PER_SET = 150
MOST_COUNTS = 100  # in a period: more edges do not fit through the pins


def pose_sets(machine: Machine) -> dict[str, np.ndarray]:
    """Encoder counts (POSES_PER_SET, n) of each set, drawn with SEED and its successors."""
    if not isinstance(machine.robot, Spheiro):
        return {WHOLE: machine.drive.counts(machine.robot.workspace(POSES_PER_SET, SEED))}
    return {
        name: counts_at(sample_workspace(POSES_PER_SET, spheiro_of(machine), SEED + k, **limits), machine)
        for k, (name, limits) in enumerate(SETS.items())
    }


def motion(machine: Machine, n_poses: int, start_s: float = 0.0, period_s: float = 1e-3) -> np.ndarray:
    """Encoder counts (n_poses, n) every period_s, from start_s on, of a smooth motion.

    The Sphe.I.Ro. starts at rest at home: the tilt swings out and back to 20 deg while its azimuth turns and the
    torsion swings, so that all axes reverse. Any other robot swings each axis about a pose.
    """
    t = start_s + np.arange(n_poses) * period_s
    if not isinstance(machine.robot, Spheiro):
        return _swing(machine, t, period_s)
    tilt = np.deg2rad(10.0) * (1 - np.cos(2 * np.pi * 0.5 * t))
    return counts_at(pose(2 * np.pi * 0.4 * t, tilt, np.deg2rad(8.0) * np.sin(2 * np.pi * 0.7 * t)), machine)


def _swing(machine: Machine, t: np.ndarray, period_s: float) -> np.ndarray:
    """Counts (k, n) about the first pose of the workspace, each axis with a frequency of its own; at most a tenth of
    its range away from it, and MOST_COUNTS in a period."""
    pose_counts = machine.drive.counts(machine.robot.workspace(1, SEED))
    ranges = machine.drive.counts(np.array([axis.high - axis.low for axis in machine.axes]))
    rate = 2 * np.pi * (0.5 + 0.1 * np.arange(machine.n_axes))
    reach = np.minimum(ranges / 10, MOST_COUNTS / (rate * period_s))
    return np.rint(pose_counts + reach * np.sin(rate * t[:, None])).astype(np.int64)


def counts_at(rotation: np.ndarray, machine: Machine) -> np.ndarray:
    """Encoder counts (..., 3) at poses (..., 3, 3): q over the encoder's step, rounded."""
    return machine.drive.counts(inverse_kinematics(rotation, spheiro_of(machine)))
