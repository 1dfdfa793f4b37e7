"""Runs of the robot in the physics engine with gc_system in the loop: what they are, and what their logs say.

Time starts when the brakes open. Each run holds a pose, steps to others if it has steps, then moves slowly.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.robot import Spheiro
from gravcomp.robot.spheiro.workspace import pose

STILL = 1e-4  # rad/s of the platform, or m/s where there is none
SETTLING_S = 0.25  # of the servo after a step
_START_RAD = np.deg2rad([40.0, 18.0, 6.0])  # azimuth, tilt, torsion


class Fault(StrEnum):
    """What is injected."""

    NONE = "none"
    ESTOP = "emergency stop"
    ENCODER = "encoder fault"


@dataclass(frozen=True)
class Move:
    """From rest to rest by distance_m per axis; there is no jump in acceleration."""

    start_s: float
    duration_s: float
    distance_m: tuple[float, float, float]

    @property
    def end_s(self) -> float:
        """When it is at rest again."""
        return self.start_s + self.duration_s

    def way_m(self, t_s: float, n_axes: int) -> np.ndarray:
        """How far the first axes have come (n_axes,) at t."""
        x = np.clip((t_s - self.start_s) / self.duration_s, 0.0, 1.0)
        return np.array(self.distance_m[:n_axes]) * x**3 * (10 - 15 * x + 6 * x**2)


def start_m(machine: Machine) -> np.ndarray:
    """Where a run begins (n,): of the Sphe.I.Ro. a tilted pose, of others the middles of the axes."""
    if isinstance(machine.robot, Spheiro):
        return inverse_kinematics(pose(*_START_RAD), machine.robot.parameters)
    return np.array([(axis.low + axis.high) / 2 for axis in machine.axes])


def slowly(start_s: float, duration_s: float) -> Move:
    """A move at 3 mm/s on average, 5.6 mm/s at most, of the fastest axis."""
    length_m = 3e-3 * duration_s
    return Move(start_s, duration_s, (length_m, -0.6 * length_m, 0.4 * length_m))


@dataclass(frozen=True)
class Run:
    """Holding, steps, a slow move, then rest until duration_s; a fault comes at fault_s.

    uses_network: the core holds its network, and not one that says nothing. closing_s: of the brakes.
    """

    name: str
    uses_network: bool
    move: Move
    duration_s: float
    steps: tuple[Move, ...] = ()
    fault: Fault = Fault.NONE
    fault_s: float = np.inf
    closing_s: float = 0.0

    def target_m(self, t_s: float, machine: Machine) -> np.ndarray:
        """Where the axes of a machine (n,) shall be at t."""
        ways = [move.way_m(t_s, machine.n_axes) for move in (*self.steps, self.move)]
        return start_m(machine) + sum(ways)

    @property
    def hold_s(self) -> float:
        """How long the first pose is held."""
        return min(move.start_s for move in (*self.steps, self.move))

    def phases(self, t_s: np.ndarray) -> dict[str, np.ndarray]:
        """Which samples (n,) belong to which phase; each belongs to one."""
        stepping = np.zeros(len(t_s), bool)
        for step in self.steps:
            stepping |= (t_s >= step.start_s) & (t_s < step.end_s + SETTLING_S)
        holding, moving = t_s < self.hold_s, t_s >= self.move.start_s
        settled = ~(holding | stepping | moving)
        return {"holding": holding, "stepping": stepping, "holding after steps": settled, "moving slowly": moving}


def with_faults(hold: Run, moving: Run, closing_s: tuple[float, ...]) -> tuple[Run, ...]:
    """A run with the servo alone, the same with the network, then faults in mid-motion."""
    stops = [replace(moving, name=f"estop_{1e3 * s:.0f}ms", fault=Fault.ESTOP, closing_s=s) for s in closing_s]
    encoder = replace(moving, name="encoder_fault", fault=Fault.ENCODER, closing_s=closing_s[-1])
    return hold, replace(hold, name="network", uses_network=True), *stops, encoder


FULL = with_faults(
    Run(
        "servo",
        False,
        slowly(1.5, 0.8),
        2.3,
        steps=(Move(0.5, 0.15, (1e-3, -0.6e-3, 0.4e-3)), Move(1.0, 0.15, (-0.4e-3, 1e-3, 0.7e-3))),
    ),
    Run("", True, slowly(0.0, 0.4), 0.3, fault_s=0.2),
    (0.0, 0.01),
)
SHORT = with_faults(
    Run("servo", False, slowly(0.1, 0.1), 0.1),
    Run("", True, slowly(0.0, 0.12), 0.09, fault_s=0.06),
    (0.0,),
)


SETS = {"full": FULL, "short": SHORT}


@dataclass(frozen=True)
class Log:
    """What happened from the opening of the brakes on, every TIME_STEP_S.

    t_s (n,); target_m, q_m (n, axes): wanted and true positions; servo_n, network_n (n, axes): what servo and network
    asked of the motors; is_released (n,): all brakes have current; speed (n,): of the platform, rad/s, or of the axes,
    m/s, where there is none. reaction_clocks: from the injected fault to the brakes' pins, 0 without one.
    """

    t_s: np.ndarray
    target_m: np.ndarray
    q_m: np.ndarray
    servo_n: np.ndarray
    network_n: np.ndarray
    is_released: np.ndarray
    speed: np.ndarray
    reaction_clocks: int

    def error_m(self) -> np.ndarray:
        """Tracking error (n, 3), target - position."""
        return self.target_m - self.q_m

    def motor_n(self) -> np.ndarray:
        """Forces of the motors (n, 3)."""
        return self.servo_n + self.network_n


@dataclass(frozen=True)
class AfterFault:
    """After a fault: time until all is still for good, s (inf: never); how far the carriages went on (worst axis), m;
    speed at the fault and at the end, as in Log."""

    still_s: float
    drop_m: float
    speed: float
    last_speed: float


def stop_after(run: Run, log: Log) -> AfterFault:
    """How the robot of a run with a fault came to rest."""
    after = log.t_s >= run.fault_s
    moving = np.flatnonzero(log.speed[after] > STILL)
    speeds, path_m = log.speed[after], np.abs(log.q_m[after] - log.q_m[after][0])
    n_moving = moving[-1] + 1 if len(moving) else 0
    still_s = n_moving * TIME_STEP_S if n_moving < len(speeds) else np.inf
    return AfterFault(still_s, float(path_m.max()), float(speeds[0]), float(speeds[-1]))


def rms(values: np.ndarray) -> float:
    """Over time and axes."""
    return float(np.sqrt(np.mean(values**2)))
