"""What the drives and brakes of gc_system act on: the robot in the physics engine, and the host's PID."""

import numpy as np

from gravcomp.prototype.body import SERVO_KD_NS_PER_M, SERVO_KI_N_PER_MS, SERVO_KP_N_PER_M, Prototype
from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.robot.spheiro.kinematics import direct_kinematics
from gravcomp.robot.spheiro.parameters import RobotParameters

BRAKE_N = 400.0  # holding force of one brake, a stand-in: three times the largest force of the workspace
_RATE_BLEND = TIME_STEP_S / (TIME_STEP_S + 0.005)  # the error's rate is filtered with 5 ms


class Pid:
    """f = K_p e + K_i sum(e) T + K_d rate(e) per axis, N, every TIME_STEP_S; starts with an empty integrator."""

    def __init__(self) -> None:
        self._last_m: np.ndarray | None = None
        self._sum_ms, self._rate_mps = np.zeros(3), np.zeros(3)

    def force_n(self, error_m: np.ndarray) -> np.ndarray:
        """Motor forces (3,), N, for errors (3,), m, target - reading."""
        last_m = error_m if self._last_m is None else self._last_m
        self._rate_mps += _RATE_BLEND * ((error_m - last_m) / TIME_STEP_S - self._rate_mps)
        self._sum_ms += error_m * TIME_STEP_S
        self._last_m = error_m
        return SERVO_KP_N_PER_M * error_m + SERVO_KI_N_PER_MS * self._sum_ms + SERVO_KD_NS_PER_M * self._rate_mps


class BrakedPrototype:
    """The prototype with a brake on each carriage: dry friction of BRAKE_N. At first still, brakes engaged.

    closing_s: what a brake takes to close; it opens at once.
    """

    def __init__(self, p: RobotParameters, q_m: np.ndarray, closing_s: float = 0.0):
        self._robot = Prototype(p)
        self._robot.set_pose(direct_kinematics(q_m, p))
        self._closing_steps = round(closing_s / TIME_STEP_S)
        self._steps_since_released = np.full(3, self._closing_steps)

    @property
    def q_m(self) -> np.ndarray:
        """Positions of the carriages (3,), m."""
        return self._robot.motor_positions().copy()

    @property
    def platform_radps(self) -> float:
        """Angular speed of the platform."""
        return float(np.linalg.norm(self._robot.data.joint("platform").qvel[3:]))

    def step(self, force_n: np.ndarray, is_released: np.ndarray) -> None:
        """TIME_STEP_S of physics under motor forces (3,), N; is_released (3,): current in the coils of the brakes."""
        robot = self._robot
        is_engaged = ~is_released & (self._steps_since_released >= self._closing_steps)
        self._steps_since_released = np.where(is_released, 0, self._steps_since_released + 1)
        robot.model.dof_frictionloss[robot.motor_dofs] = np.where(is_engaged, BRAKE_N, 0.0)
        robot.data.ctrl[:] = force_n
        robot.mujoco.mj_step(robot.model, robot.data)
