"""The virtual prototype with its effects, encoders and PID: one call, one millisecond."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.prototype.body import Prototype
from gravcomp.prototype.engine import SERVO_PER_KG, TIME_STEP_S, Engine
from gravcomp.prototype.imperfections import Imperfection, PlantState
from gravcomp.prototype.mechanism_engine import MechanismEngine
from gravcomp.prototype.sizes import Sizes, sizes_of
from gravcomp.robot.machine import Machine
from gravcomp.robot.mechanism.robot import Mechanism
from gravcomp.robot.spheiro.robot import Spheiro

_RATE_BLEND = TIME_STEP_S / (TIME_STEP_S + 0.005)  # the error's rate is filtered with 5 ms
_LARGEST_ERROR_M = 0.002  # of the Sphe.I.Ro.
_AMBIENT_C, _WARMING_C, _WARMING_S = 22.0, 15.0, 300.0
# Gives imperfections that suit a machine.
MakeImperfections = Callable[[Engine, Sizes], Sequence[Imperfection]]


def engine_of(machine: Machine) -> Engine:
    """The machine in the physics engine. Raises InputError for a kind that has no mechanics."""
    robot = machine.robot
    if isinstance(robot, Spheiro):
        return Prototype(robot.parameters)
    if isinstance(robot, Mechanism):
        return MechanismEngine(robot, Path(machine.where).parent / machine.table["model"]["file"])
    raise InputError(f'{machine.where}: [model] kind has no mechanics to measure on; give "mujoco" or "spheiro"')


class Plant:
    """Motors under a PID that sees what the encoders read.

    ``reading`` (n,), m or rad, is the last quantised reading; ``state`` is what the effects see. effects: what the
    model lacks, or a function that gives it for the machine in the engine and its sizes.
    """

    def __init__(self, machine: Machine, effects: Sequence[Imperfection] | MakeImperfections = ()):
        self.machine, self._drive = machine, machine.drive
        self.engine = robot = engine_of(machine)
        robot.mujoco.set_mju_user_warning(lambda message: None)  # or the engine leaves a log file; see check_control
        self.sizes = sizes_of(machine, robot)
        self.effects = effects = list(effects(robot, self.sizes) if callable(effects) else effects)
        with np.errstate(all="ignore"):  # an effect beyond all numbers: check_control says so
            for effect in effects:
                effect.install(robot)
        robot.mujoco.mj_setConst(robot.model, robot.data)
        n = machine.n_axes
        self.state = PlantState(*np.zeros((4, n)))
        self._last, self._held, self._rate = np.zeros((3, n))  # of the PID: error, integrated effort, rate of the error
        self._guide_friction = robot.model.dof_frictionloss[robot.motor_dofs].copy()
        self._frictions, self._forces, self._shifts, self._reports = (
            [getattr(effect, hook) for effect in effects if hook in vars(type(effect))]
            for hook in ("friction", "force", "shift", "reported")
        )

    def place(self, q: np.ndarray, v: np.ndarray, t_s: float) -> None:
        """Put the robot where the encoders read q (n,), m or rad, on its way with speeds v (n,).

        PID and effects start in the state that steady motion with this velocity leads to. Raises PoseError.
        """
        robot, state = self.engine, self.state
        state.t_s, state.q, state.v = t_s, q, v
        state.statics = state.motor = self.machine.robot.forces(q)
        self._reset_effects()
        state.q = q - sum(shift(state) for shift in self._shifts)
        self._reset_effects()  # asking for the shift was a step of their history
        robot.place(state.q, v)
        self._mass = robot.moved_mass()
        self._apply_forces()
        state.motor = robot.equilibrium_efforts()
        self.reading = self.read()
        self._last, self._held, self._rate = q - self.reading, state.motor.copy(), np.zeros(len(q))

    def step(self, target: np.ndarray) -> None:
        """One time step of PID and physics towards a target (n,), m or rad, in encoder readings."""
        self.reading = self.read()
        error = target - self.reading
        proportional, integral, rate = SERVO_PER_KG
        self._rate = self._rate + _RATE_BLEND * ((error - self._last) / TIME_STEP_S - self._rate)
        self._held = self._held + integral * TIME_STEP_S * (self._mass @ error)
        self._last = error
        self.exert(self._mass @ (proportional * error + rate * self._rate) + self._held)

    def exert(self, motor: np.ndarray) -> None:
        """One time step of physics alone, under efforts of the motors (n,), N or N m."""
        robot, state = self.engine, self.state
        robot.data.ctrl[:] = state.motor = motor
        self._apply_forces()
        robot.mujoco.mj_step(robot.model, robot.data)
        state.q, state.v = robot.motor_positions(), robot.motor_speeds()
        state.t_s += TIME_STEP_S

    def pass_by(self, q: np.ndarray) -> None:
        """Tell the effects what the model holds at q (n,), where the motion is now."""
        self.state.statics = self.machine.robot.forces(q)

    def temperature_c(self) -> float:
        """Of the motors, which warm up from the start of the log."""
        return _AMBIENT_C + _WARMING_C * (1.0 - np.exp(-self.state.t_s / _WARMING_S))

    def effort(self) -> np.ndarray:
        """What the drives report (n,), as an effort, N or N m, for what the motors exert now."""
        effort, self.state.temperature_c = self.state.motor, self.temperature_c()
        for report in self._reports:
            effort = report(effort, self.state)
        return effort

    def check_control(self) -> None:
        """Raise InputError when the PID has lost the robot."""
        has_diverged = any(warning.number for warning in self.engine.data.warning)
        if has_diverged or not np.all(np.abs(self._last) < _LARGEST_ERROR_M * self.sizes.position):
            raise InputError(
                "the PID can't follow this motion with these effects; make them smaller or take another seed"
            )

    def _reset_effects(self) -> None:
        for effect in self.effects:
            effect.reset(self.state)

    def read(self) -> np.ndarray:
        """What the encoders read (n,), m or rad, now."""
        position = self.state.q
        for shift in self._shifts:
            position = position + shift(self.state)
        return self._drive.positions(self._drive.counts(position))

    def _apply_forces(self) -> None:
        robot, state = self.engine, self.state
        if self._forces:
            robot.data.qfrc_applied[robot.motor_dofs] = sum(force(state) for force in self._forces)
        if self._frictions:
            level = self._guide_friction + sum(friction(state) for friction in self._frictions)
            robot.model.dof_frictionloss[robot.motor_dofs] = level
