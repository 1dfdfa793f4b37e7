"""Runs of the robot in the physics engine with gc_system in the loop: what they are, what they left, what it says.

Time starts when the brakes open. Each run holds a pose, then moves away from it slowly.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.kinematics import inverse_kinematics
from gravcomp.robot.parameters import RobotParameters
from gravcomp.robot.prototype import TIME_STEP_S
from gravcomp.robot.workspace import pose

MEAN_SPEED_MPS = 3e-3  # of the fastest axis
STILL_RADPS = 1e-4
_START_RAD = np.deg2rad([40.0, 18.0, 6.0])  # azimuth, tilt, torsion
_DIRECTION = np.array([1.0, -0.6, 0.4])  # of the motion, per axis


class Fault(StrEnum):
    """What is injected."""

    NONE = "none"
    ESTOP = "emergency stop"
    ENCODER = "encoder fault"


@dataclass(frozen=True)
class Run:
    """hold_s of holding, move_s of moving, then rest until duration_s; a fault comes at fault_s.

    uses_core: the core's commands act on the motors beside the PID. closing_s: of the brakes.
    """

    name: str
    uses_core: bool
    hold_s: float
    move_s: float
    duration_s: float
    fault: Fault = Fault.NONE
    fault_s: float = np.inf
    closing_s: float = 0.0

    def target_m(self, t_s: float, p: RobotParameters) -> np.ndarray:
        """Where the carriages (3,) shall be at t: there is no jump in acceleration."""
        start = inverse_kinematics(pose(*_START_RAD), p)
        x = np.clip((t_s - self.hold_s) / self.move_s, 0.0, 1.0)
        return start + MEAN_SPEED_MPS * self.move_s * _DIRECTION * x**3 * (10 - 15 * x + 6 * x**2)


def with_faults(hold: Run, moving: Run, closing_s: tuple[float, ...]) -> tuple[Run, ...]:
    """A run with the PID alone, the same with the core, then faults in mid-motion."""
    stops = [replace(moving, name=f"estop_{1e3 * s:.0f}ms", fault=Fault.ESTOP, closing_s=s) for s in closing_s]
    encoder = replace(moving, name="encoder_fault", fault=Fault.ENCODER, closing_s=closing_s[-1])
    return hold, replace(hold, name="core", uses_core=True), *stops, encoder


FULL = with_faults(
    Run("pid", False, hold_s=0.5, move_s=0.8, duration_s=1.5),
    Run("", True, hold_s=0.0, move_s=0.8, duration_s=0.55, fault_s=0.4),
    (0.0, 0.01),
)
SHORT = with_faults(
    Run("pid", False, hold_s=0.1, move_s=0.1, duration_s=0.1),
    Run("", True, hold_s=0.0, move_s=0.12, duration_s=0.09, fault_s=0.06),
    (0.0,),
)


@dataclass(frozen=True)
class Log:
    """What happened from the opening of the brakes on, every TIME_STEP_S.

    t_s (n,); target_m, q_m (n, 3): wanted and true positions; pid_n, core_n (n, 3): what PID and core asked of the
    motors; is_released (n,): all brakes have current; platform_radps (n,). reaction_clocks: from the injected fault to
    the brakes' pins, 0 without one.
    """

    t_s: np.ndarray
    target_m: np.ndarray
    q_m: np.ndarray
    pid_n: np.ndarray
    core_n: np.ndarray
    is_released: np.ndarray
    platform_radps: np.ndarray
    reaction_clocks: int

    def error_m(self) -> np.ndarray:
        """Tracking error (n, 3), target - position."""
        return self.target_m - self.q_m

    def motor_n(self) -> np.ndarray:
        """Forces of the motors (n, 3)."""
        return self.pid_n + self.core_n


@dataclass(frozen=True)
class Stop:
    """After a fault: time until the platform is still for good, s (inf: never); how far the carriages went on (worst
    axis), m; speed of the platform at the fault and at the end, rad/s."""

    still_s: float
    drop_m: float
    speed_radps: float
    last_speed_radps: float


def stop_after(run: Run, log: Log) -> Stop:
    """How the robot of a run with a fault came to rest."""
    after = log.t_s >= run.fault_s
    moving = np.flatnonzero(log.platform_radps[after] > STILL_RADPS)
    speeds, path_m = log.platform_radps[after], np.abs(log.q_m[after] - log.q_m[after][0])
    n_moving = moving[-1] + 1 if len(moving) else 0
    still_s = n_moving * TIME_STEP_S if n_moving < len(speeds) else np.inf
    return Stop(still_s, float(path_m.max()), float(speeds[0]), float(speeds[-1]))


def rms(values: np.ndarray) -> float:
    """Over time and axes."""
    return float(np.sqrt(np.mean(values**2)))


def save(folder: Path, run: Run, log: Log) -> None:
    """Write <folder>/<name of the run>.npz."""
    folder.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(folder / f"{run.name}.npz", **vars(log))


def load(folder: Path, run: Run) -> Log:
    """Read what save wrote. Raises InputError when it is not there, or damaged."""
    path = folder / f"{run.name}.npz"
    try:
        with np.load(path) as saved:
            return Log(**{name: saved[name] for name in saved.files})
    except (OSError, ValueError, TypeError, EOFError, BadZipFile):
        raise InputError(f"{path}: no such run, or a damaged one; start `make hil` first") from None
