"""The robot at the pins of gc_system, its brakes dry friction that takes its time to close."""

from pathlib import Path

import numpy as np

from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.robot import Spheiro
from gravcomp_lab.cosim.world import World

BRAKE_N = 400.0  # holding force of one brake, a stand-in: three times the largest force of the workspace


class FrictionBrakes:
    """A brake per axis: dry friction of BRAKE_N on its carriage without current. It opens at once.

    closing_s: what it takes to close.
    """

    def __init__(self, n_axes: int, closing_s: float = 0.0):
        self._closing_steps = round(closing_s / TIME_STEP_S)
        self._since_released = np.full(n_axes, self._closing_steps)

    def friction_n(self, is_released: np.ndarray) -> np.ndarray:
        """In the next TIME_STEP_S (n,), N; is_released (n,): current in the coils."""
        is_engaged = ~is_released & (self._since_released >= self._closing_steps)
        self._since_released = np.where(is_released, 0, self._since_released + 1)
        return np.where(is_engaged, BRAKE_N, 0.0)


class BrakedWorld(World):
    """A robot in the physics engine at the pins of the core in a library, with FrictionBrakes.

    A host of no cost: an access takes the clocks of the bus, and no time of a line.
    """

    def __init__(self, library: Path, machine: Machine, closing_s: float = 0.0):
        super().__init__(library, machine)
        self._brakes = FrictionBrakes(machine.n_axes, closing_s)
        self._noise_ua = np.zeros(machine.n_axes)
        robot = self.plant.engine
        self._guides = robot.model.dof_frictionloss[robot.motor_dofs].copy()

    @property
    def is_released(self) -> np.ndarray:
        """Which brakes have current (n,)."""
        return np.array([self.port.released >> axis & 1 for axis in range(self.machine.n_axes)], bool)

    @property
    def q_m(self) -> np.ndarray:
        """Positions of the carriages (n,), m."""
        return self.plant.engine.motor_positions().copy()

    @property
    def speed(self) -> float:
        """Angular speed of the platform, rad/s, or of all axes, m/s, where there is none."""
        robot = self.plant.engine
        is_platform = isinstance(self.machine.robot, Spheiro)
        return float(np.linalg.norm(robot.data.joint("platform").qvel[3:] if is_platform else robot.motor_speeds()))

    def clock(self) -> None:
        """One clock of the core."""
        self._run(1)

    def _exchange(self) -> None:
        self.sent += 1

    def _move(self, motor: np.ndarray) -> None:
        robot = self.plant.engine
        robot.model.dof_frictionloss[robot.motor_dofs] = self._guides + self._brakes.friction_n(self.is_released)
        self.plant.exert(motor)
