"""Samples of the built-in robot for tests of the measured side: holds and slow motion, without any effect or noise."""

from pathlib import Path

import numpy as np

from gravcomp.logs.measurement import Measurement
from machines import MACHINE

REACH_M = 0.08  # inside the joint space for any combination of signs
MOTION_M = 0.06
MOTION_RAD_PER_S = np.array([0.5, 0.67, 0.83])
MOTION_PHASE_RAD = np.array([0.3, 1.1, 2.0])
QUANTITIES = (("q", "m"), ("v", "mps"), ("f", "n"))


def sampled(t_s, q, v, temp_c=None) -> Measurement:
    """Rows of the robot whose measured force is the model's."""
    robot = MACHINE.robot
    f = robot.forces(q)
    return Measurement("samples", t_s, q, v, f, f, "N", ("m",) * 3, temp_c=temp_c, force_at=robot.forces, robot=robot)


def holds(n: int, seed: int) -> Measurement:
    """Scattered poses, approached at 0.2 to 10 mm/s in either direction; warming from 20 to 40 degC."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-REACH_M, REACH_M, (n, 3))
    v = np.exp(rng.uniform(np.log(2e-4), np.log(1e-2), q.shape)) * rng.choice([-1.0, 1.0], q.shape)
    return sampled(2.0 * np.arange(n), q, v, np.linspace(20.0, 40.0, n))


def write_log(path: Path, t_s, q_m, v_mps, force_n) -> None:
    """A log as a robot's control writes it: positions, velocities and forces of n axes."""
    axes = range(1, q_m.shape[1] + 1)
    head = ",".join(["t_s", *(f"{name}{axis}_{unit}" for name, unit in QUANTITIES for axis in axes)])
    rows = np.column_stack([t_s, q_m, v_mps, force_n])
    np.savetxt(path, rows, "%.9g", delimiter=",", header=head, comments="")


def motion(n: int) -> Measurement:
    """q_i = 60 mm sin(w_i t + p_i), 20 rows per second; its acceleration is -w_i^2 q_i."""
    t = 0.05 * np.arange(n)
    angle = t[:, None] * MOTION_RAD_PER_S + MOTION_PHASE_RAD
    return sampled(t, MOTION_M * np.sin(angle), MOTION_M * MOTION_RAD_PER_S * np.cos(angle))


def arm(n: int, seed: int) -> Measurement:
    """One rotary axis with a model of its own, 8 Nm cos q."""
    q = np.random.default_rng(seed).uniform(-1.5, 1.5, (n, 1))
    torque = 8.0 * np.cos(q)
    return Measurement("arm", 2.0 * np.arange(n), q, None, torque, torque, "Nm", ("rad",))
