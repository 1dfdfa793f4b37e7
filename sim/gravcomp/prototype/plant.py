"""The virtual prototype with its effects, encoders and PID: one call, one millisecond."""

from collections.abc import Sequence

import numpy as np

from gravcomp.errors import InputError
from gravcomp.prototype.body import SERVO_KD_NS_PER_M, SERVO_KI_N_PER_MS, SERVO_KP_N_PER_M, TIME_STEP_S, Prototype
from gravcomp.prototype.imperfections import Effect, State
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import direct_kinematics
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp.robot.spheiro.statics import holding_forces_at

# Acting on the error, the sum of all errors, and the error's rate behind a first-order filter of 5 ms.
_PID_GAINS = np.array([SERVO_KP_N_PER_M, SERVO_KI_N_PER_MS * TIME_STEP_S, SERVO_KD_NS_PER_M])
_RATE_BLEND = TIME_STEP_S / (TIME_STEP_S + 0.005)
_LARGEST_ERROR_M = 0.002
_AMBIENT_C, _WARMING_C, _WARMING_S = 22.0, 15.0, 300.0


class Plant:
    """Motors under a PID that sees what the encoders read.

    ``reading_m`` (3,), m, is the last quantised reading; ``state`` is what the effects see.
    """

    def __init__(self, machine: Machine, effects: Sequence[Effect] = ()):
        self.parameters = p = spheiro_of(machine)
        self._drive = machine.drive
        self.robot = robot = Prototype(p)
        robot.mujoco.set_mju_user_warning(lambda message: None)  # or the engine leaves a log file; see check_control
        for effect in effects:
            effect.install(robot)
        robot.mujoco.mj_setConst(robot.model, robot.data)
        self.state = State()
        self._pid = np.zeros((3, 3))  # rows as in _PID_GAINS, a column per motor
        self._effects = effects
        self._guide_friction_n = robot.model.dof_frictionloss[robot.motor_dofs].copy()
        self._frictions, self._forces, self._shifts, self._efforts = (
            [getattr(effect, hook) for effect in effects if hook in vars(type(effect))]
            for hook in ("friction_n", "force_n", "shift_m", "effort_n")
        )

    def place(self, q_m: np.ndarray, v_mps: np.ndarray, t_s: float) -> None:
        """Put the robot where the encoders read q (3,), m, on its way with velocity v (3,), m/s.

        PID and effects start in the state that steady motion with this velocity leads to. Raises PoseError.
        """
        robot, state = self.robot, self.state
        state.t_s, state.q_m, state.v_mps = t_s, q_m, v_mps
        state.statics_n = state.motor_n = holding_forces_at(q_m, self.parameters)
        self._reset_effects()
        state.q_m = q_m - sum(shift(state) for shift in self._shifts)
        self._reset_effects()  # asking for the shift was a step of their history
        robot.set_pose(direct_kinematics(state.q_m, self.parameters), v_mps)
        self._apply_forces()
        state.motor_n = robot.equilibrium_forces()
        self.reading_m = self._read()
        self._pid[:] = q_m - self.reading_m, state.motor_n / _PID_GAINS[1], np.zeros(3)

    def step(self, target_m: np.ndarray) -> None:
        """One time step of PID and physics towards a target (3,), m, in encoder readings."""
        robot, state = self.robot, self.state
        self.reading_m = self._read()
        error = target_m - self.reading_m
        last, total, rate = self._pid
        rate += _RATE_BLEND * ((error - last) / TIME_STEP_S - rate)
        total += error
        last[:] = error
        state.motor_n = _PID_GAINS @ self._pid
        robot.data.ctrl[:] = state.motor_n
        self._apply_forces()
        robot.mujoco.mj_step(robot.model, robot.data)
        state.q_m, state.v_mps = robot.motor_positions(), robot.data.qvel[robot.motor_dofs]
        state.t_s += TIME_STEP_S

    def temperature_c(self) -> float:
        """Of the motors, which warm up from the start of the log."""
        return _AMBIENT_C + _WARMING_C * (1.0 - np.exp(-self.state.t_s / _WARMING_S))

    def effort_n(self) -> np.ndarray:
        """What the drives report (3,), as a force, N, for what the motors exert now."""
        effort, self.state.temperature_c = self.state.motor_n, self.temperature_c()
        for report in self._efforts:
            effort = report(effort, self.state)
        return effort

    def check_control(self) -> None:
        """Raise InputError when the PID has lost the robot."""
        has_diverged = any(warning.number for warning in self.robot.data.warning)
        if has_diverged or not np.abs(self._pid[0]).max() < _LARGEST_ERROR_M:
            raise InputError("the PID can't move the prototype with these effects; make them smaller")

    def _reset_effects(self) -> None:
        for effect in self._effects:
            effect.reset(self.state)

    def _read(self) -> np.ndarray:
        position = self.state.q_m
        for shift in self._shifts:
            position = position + shift(self.state)
        return self._drive.positions(self._drive.counts(position))

    def _apply_forces(self) -> None:
        robot, state = self.robot, self.state
        if self._forces:
            robot.data.qfrc_applied[robot.motor_dofs] = sum(force(state) for force in self._forces)
        if self._frictions:
            level = self._guide_friction_n + sum(friction(state) for friction in self._frictions)
            robot.model.dof_frictionloss[robot.motor_dofs] = level
