"""What every robot of the physics engine is: a MuJoCo model whose motors hold and move it."""

from abc import ABC, abstractmethod

import numpy as np

from gravcomp.errors import InputError

TIME_STEP_S = 1e-3
# As stiff as the time step allows: a rigid tie gives way by some nanometres under a robot's weight.
STIFF_SOLREF = (2 * TIME_STEP_S, 1.0)
STIFF_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)

# PID per kg or kg m^2 moved: position, integral, rate, with all three poles of the servo at one place.
_SERVO_RAD_PER_S = 30.0
SERVO_PER_KG = (3 * _SERVO_RAD_PER_S**2, _SERVO_RAD_PER_S**3, 3 * _SERVO_RAD_PER_S)


class Engine(ABC):
    """``model`` and ``data`` are MuJoCo's, imperfections may change the model; ``mujoco`` is the module.

    motor_dofs (n,): degrees of freedom with a motor, hinges and slides; actuators are theirs, in the same order.
    """

    mujoco: object
    model: object
    data: object
    motor_dofs: np.ndarray

    @abstractmethod
    def place(self, q: np.ndarray, v: np.ndarray | None = None) -> None:
        """Put the whole chain at positions q (n,), m or rad, at rest or with the axes' speeds v (n,).

        Raises PoseError.
        """

    @abstractmethod
    def passive_dofs(self, unit: str) -> np.ndarray:
        """Degrees of freedom of the passive slides ("m") or hinges ("rad")."""

    @abstractmethod
    def moved_mass(self) -> np.ndarray:
        """M (n, n), kg or kg m^2, that the servo counts with at the present pose."""

    @abstractmethod
    def add_mass(self, mass_kg: float, place_m: np.ndarray) -> None:
        """A point mass at place_m (3,) in the frame of the body that takes a payload.

        Raises InputError where a negative one leaves nothing.
        """

    heavy_bodies: tuple[str, ...] = ()  # with a mass that may be elsewhere than the model has it

    def add_moment(self, body: str, moment_kgm: np.ndarray) -> None:
        """A first moment (3,) in the frame of a body: its mass is not where the model has it. Raises InputError."""
        if body not in self.heavy_bodies:
            known = ", ".join(self.heavy_bodies)
            raise InputError(f"--effect body_moment: body {body!r} is not known, or has no mass; give one of {known}")
        self.model.body(body).ipos[:] += moment_kgm / self.model.body(body).mass[0]

    @property
    def motor_joints(self) -> np.ndarray:
        """Numbers of the joints with a motor, (n,)."""
        return self.model.dof_jntid[self.motor_dofs]

    def motor_positions(self) -> np.ndarray:
        """q (n,), m or rad, as the engine has it."""
        return self.data.qpos[self.model.jnt_qposadr[self.motor_joints]]

    def motor_speeds(self) -> np.ndarray:
        """Speeds (n,), m/s or rad/s, as the engine has them."""
        return self.data.qvel[self.motor_dofs]

    def closure_error(self) -> float:
        """Largest violation of what closes the chain, m or rad."""
        return float(np.abs(self.data.efc_pos[self._closure_rows()]).max(initial=0.0))

    def equilibrium_efforts(self) -> np.ndarray:
        """Motor efforts (n,), N or N m, that keep the robot as it is: at rest, or in slow motion against its friction.

        S^T f + J_c^T lambda = weight - springs and dampers - applied forces + friction, with the constraint Jacobian
        J_c: f is the only one, lambda may be one of many.
        """
        data = self.data
        friction = self.model.dof_frictionloss * np.sign(data.qvel)
        load = data.qfrc_bias - data.qfrc_passive - data.qfrc_applied + friction
        return np.linalg.lstsq(self._motors_and_closure().T, load)[0][: len(self.motor_dofs)]

    def _motors_and_closure(self) -> np.ndarray:
        """S over J_c: maps all joint velocities to those of the motors and of the closure's violation."""
        constraint = self.data.efc_J.reshape(-1, self.model.nv)[self._closure_rows()]
        return np.vstack([np.eye(self.model.nv)[self.motor_dofs], constraint])

    def _closure_rows(self) -> np.ndarray:
        return self.data.efc_type == self.mujoco.mjtConstraint.mjCNSTR_EQUALITY
