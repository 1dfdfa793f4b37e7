"""The same closed chain in MuJoCo: independent witness of the statics and body of the virtual prototype.

Three legs, each a carriage sliding along e_i (motor), link 1 turning about e_i, link 2 sliding along w_i and a fork on
a universal joint (inner axis e_i x w_i, outer axis u_i), are welded to a free platform by equality constraints. No
contact. Masses and lengths come from RobotParameters; inertias, which statics don't see, are those of bodies with a
radius of gyration of d/4. At home every joint coordinate is zero and every body frame is the base frame.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from gravcomp.errors import InputError, optional
from gravcomp.prototype.engine import SERVO_PER_KG, STIFF_SOLIMP, STIFF_SOLREF, TIME_STEP_S, Engine
from gravcomp.robot.spheiro.kinematics import (
    HOME_AXES,
    direct_kinematics,
    inverse_kinematics,
    passive_coordinates,
    universal_angles,
)
from gravcomp.robot.spheiro.parameters import RobotParameters

JOINTS_OF_LEG = ("carriage", "turn", "slide", "inner", "outer")
# The fork is weightless in effect; armature on its hinges keeps the constraints well scaled and bears no weight.
_FORK_MASS_KG = 1e-6
_FORK_ARMATURE_KGM2 = 0.01
_SOLREF, _SOLIMP = (" ".join(map(repr, values)) for values in (STIFF_SOLREF, STIFF_SOLIMP))
# Servo with all three poles at one place, for the mass that a motor moves (16 to 21 kg over the workspace).
_MOVED_KG = 17.0
SERVO_KP_N_PER_M, SERVO_KI_N_PER_MS, SERVO_KD_NS_PER_M = (_MOVED_KG * gain for gain in SERVO_PER_KG)


def prototype_mjcf(p: RobotParameters) -> str:
    """MJCF of the robot; joints are named like carriage1, actuators like motor1 (force in N along +q_i)."""
    legs, welds, motors = (
        "".join(part(i, p) for i in range(3))
        for part in (
            _leg,
            lambda i, p: f'<weld body1="platform" body2="fork{i + 1}" solref="{_SOLREF}" solimp="{_SOLIMP}"/>',
            lambda i, p: f'<motor name="motor{i + 1}" joint="carriage{i + 1}"/>',
        )
    )
    return f"""<mujoco model="spheiro">
<compiler angle="radian"/>
<option timestep="{TIME_STEP_S}" gravity="{_text(p.gravity_mps2)}" integrator="implicitfast" tolerance="1e-12">
<flag contact="disable"/></option>
<default><joint solreffriction="{_SOLREF}" solimpfriction="{_SOLIMP}"/></default>
<worldbody>{legs}
<body name="platform"><freejoint name="platform"/>{_inertial(p.platform_mass_kg, p.platform_com_m, p)}
<body name="payload"/></body></worldbody>
<equality>{welds}</equality>
<actuator>{motors}</actuator>
</mujoco>"""


def _leg(i: int, p: RobotParameters) -> str:
    n, e, u = i + 1, np.eye(3)[i], HOME_AXES[:, i]
    small = f'mass="{_FORK_MASS_KG}" diaginertia="{_text([_FORK_MASS_KG] * 3)}"'
    hinge = f'type="hinge" armature="{_FORK_ARMATURE_KGM2}"'
    return f"""
<body name="base{n}"><joint name="carriage{n}" type="slide" axis="{_text(e)}"/>
{_inertial(p.carriage_mass_kg, np.zeros(3), p)}
<body name="link1_{n}"><joint name="turn{n}" type="hinge" axis="{_text(e)}"/>
{_inertial(p.link1_mass_kg, p.link1_com_m * u, p)}
<body name="link2_{n}"><joint name="slide{n}" type="slide" axis="{_text(u)}"/>
{_inertial(p.link2_mass_kg, (p.d_m - p.link2_com_m) * u, p)}
<body name="fork{n}" pos="{_text(p.d_m * u)}"><inertial pos="0 0 0" {small}/>
<joint name="inner{n}" {hinge} axis="{_text(np.cross(e, u))}"/><joint name="outer{n}" {hinge} axis="{_text(u)}"/>
</body></body></body></body>"""


def _inertial(mass_kg: float, centre_m: np.ndarray, p: RobotParameters) -> str:
    inertia = _text([mass_kg * (p.d_m / 4) ** 2] * 3)
    return f'<inertial pos="{_text(centre_m)}" mass="{mass_kg}" diaginertia="{inertia}"/>'


def _text(vector) -> str:
    return " ".join(repr(float(v)) for v in vector)


class Prototype(Engine):
    """The Sphe.I.Ro. in the physics engine."""

    def __init__(self, p: RobotParameters):
        mujoco = optional("mujoco", "mujoco", "the prototype")  # an extra, because it costs more than all the rest

        self.mujoco = mujoco
        self.parameters = p
        self.model = mujoco.MjModel.from_xml_string(prototype_mjcf(p))
        self.data = mujoco.MjData(self.model)
        self.motor_dofs = self.dofs("carriage")

    def dofs(self, joint: str) -> np.ndarray:
        """Indices of one joint of all three legs in qvel, and in qpos, as the legs come before the platform.

        joint is one of JOINTS_OF_LEG.
        """
        return np.array([self.model.joint(f"{joint}{n}").dofadr[0] for n in (1, 2, 3)])

    def set_pose(self, rotation: np.ndarray, velocity_mps: np.ndarray | None = None) -> None:
        """Put the whole chain at a pose (3, 3), at rest or with motor velocities (3,). Raises PoseError."""
        p, data = self.parameters, self.data
        self.mujoco.mj_resetData(self.model, data)
        coordinates = _leg_coordinates(rotation, p)
        for joint, values in zip(JOINTS_OF_LEG, coordinates, strict=True):
            for n, value in enumerate(values, start=1):
                data.joint(f"{joint}{n}").qpos[0] = value
        x, y, z, w = Rotation.from_matrix(rotation).as_quat()
        data.joint("platform").qpos[:] = [0.0, 0.0, 0.0, w, x, y, z]
        self.mujoco.mj_forward(self.model, data)
        if velocity_mps is not None:
            data.qvel[:] = np.linalg.solve(self._motors_and_closure(), np.concatenate([velocity_mps, np.zeros(18)]))
            self.mujoco.mj_forward(self.model, data)

    def place(self, q: np.ndarray, v: np.ndarray | None = None) -> None:
        self.set_pose(direct_kinematics(q, self.parameters), v)

    def passive_dofs(self, unit: str) -> np.ndarray:
        """Of the cylindrical joints and link 2; the hinges of the universal joints are not among them."""
        return self.dofs({"m": "slide", "rad": "turn"}[unit])

    def moved_mass(self) -> np.ndarray:
        """The same at every pose: what the PID of the machine would be tuned for."""
        return _MOVED_KG * np.eye(3)

    def add_mass(self, mass_kg: float, place_m: np.ndarray) -> None:
        self.model.body("payload").mass[:] = mass_kg
        self.model.body("payload").ipos[:] = place_m

    def holding_forces_servo(self, rotation: np.ndarray, settle_s: float = 2.0) -> np.ndarray:
        """Motor forces (3,), N, after a PID servo has held the pose for settle_s; the engine does the mechanics.

        Raises InputError when the robot hasn't come to rest by then.
        """
        self.set_pose(rotation)
        target, integral = self.motor_positions().copy(), np.zeros(3)
        for _ in range(round(settle_s / TIME_STEP_S)):
            error = target - self.motor_positions()
            integral += SERVO_KI_N_PER_MS * error * TIME_STEP_S
            velocity = self.data.qvel[self.motor_dofs]
            self.data.ctrl[:] = SERVO_KP_N_PER_M * error + integral - SERVO_KD_NS_PER_M * velocity
            self.mujoco.mj_step(self.model, self.data)
        if np.abs(self.data.qvel).max() > 1e-4:
            raise InputError(f"the prototype isn't at rest after {settle_s} s; settle longer")
        return self.data.ctrl.copy()

    def holding_forces_algebra(self, rotation: np.ndarray) -> np.ndarray:
        """Motor forces (3,), N, that hold a pose, from the engine's equilibrium, without any motion."""
        self.set_pose(rotation)
        return self.equilibrium_efforts()


def _leg_coordinates(rotation: np.ndarray, p: RobotParameters) -> list[np.ndarray]:
    """Coordinates of all joints, in the order of JOINTS_OF_LEG, each (3,): m, rad, m, rad, rad."""
    passive, hinges = passive_coordinates(rotation, p), universal_angles(rotation, p)
    return [inverse_kinematics(rotation, p), passive[3:], passive[:3] - p.d_m, hinges[:3], hinges[3:]]
