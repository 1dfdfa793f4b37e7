"""A robot of a URDF or MJCF in the physics engine: its masses and inertias, without its geometry.

No contact, no limits, no friction or damping of the file's: imperfections are those asked for, and no others. Joints
that stand still are held by constraints, loops are closed as stiffly as the time step allows.
"""

from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.prototype.engine import STIFF_SOLIMP, STIFF_SOLREF, TIME_STEP_S, Engine
from gravcomp.robot.mechanism.robot import UNITS, Mechanism
from gravcomp.robot.mechanism.source import compiled, engine, model_spec
from gravcomp.robot.mechanism.tree import FREE

_ARMATURE = 1e-3  # of the largest inertia of its kind at least: a hinge with next to none would run away in a time step


class MechanismEngine(Engine):
    """A Mechanism, read again from its file at path, with all that moves. Raises InputError."""

    def __init__(self, robot: Mechanism, path: Path):
        self.mujoco, self.robot, self.path = engine(), robot, path
        self.model = self._compile()
        self.data = self.mujoco.MjData(self.model)
        self.motor_dofs = robot.axes
        heavy = robot.tree.mass_kg > 0
        self.heavy_bodies = tuple(name for name in robot.body_names if heavy[robot.tree.bodies.index(name)])
        self._bear()

    def _compile(self):
        mujoco, spec, tree = self.mujoco, model_spec(self.path, with_inertia=True), self.robot.tree
        for item in [*spec.actuators, *spec.keys]:
            spec.delete(item)
        for each in spec.bodies:  # as imperfections move centres of mass: what is compiled as simple keeps its own
            each.simple = False
        for dof in self.robot.axes:
            actuator = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target=tree.joints[tree.dof_joint[dof]])
            actuator.set_to_motor()
        for joint in self._held_joints():
            at = tree.model.jnt_qposadr[joint]
            place = np.zeros(mujoco.mjNEQDATA)
            place[0] = self.robot.reference[at] - tree.model.qpos0[at]
            spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=tree.joints[joint], data=place, active=True)
        option = spec.option
        option.timestep, option.tolerance = TIME_STEP_S, 1e-12
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.gravity = self.robot.gravity_mps2
        flags = mujoco.mjtDisableBit
        option.disableflags |= flags.mjDSBL_CONTACT | flags.mjDSBL_LIMIT
        model = compiled(spec, self.path)
        model.dof_frictionloss[:] = model.dof_damping[:] = 0.0
        for name, value in (("solref", STIFF_SOLREF), ("solimp", STIFF_SOLIMP)):
            getattr(model, f"dof_{name}")[:] = getattr(model, f"eq_{name}")[:] = value
        return model

    def _held_joints(self) -> np.ndarray:
        """Hinges and slides that neither are axes nor move with them."""
        tree = self.robot.tree
        still = np.setdiff1d(tree.dof_joint, tree.dof_joint[self.robot.moving_dofs])
        return still[np.isin(tree.model.jnt_type[still], list(UNITS))]

    def _bear(self) -> None:
        """Give every joint an armature that the time step can bear."""
        self.data.qpos[:] = self.robot.reference
        self.mujoco.mj_forward(self.model, self.data)
        inertia = np.diag(self._full_mass())
        turns = self.robot.tree.is_turning
        for kind in (turns, ~turns):
            if kind.any():
                short = np.maximum(_ARMATURE * inertia[kind].max() - inertia[kind], 0.0)
                self.model.dof_armature[kind] += short * (self._kinds[kind] != FREE)

    @property
    def _kinds(self) -> np.ndarray:
        return self.model.jnt_type[self.model.dof_jntid]

    def place(self, q: np.ndarray, v: np.ndarray | None = None) -> None:
        data, closed = self.data, self.robot.configurations(np.asarray(q)[None])
        self.mujoco.mj_resetData(self.model, data)
        data.qpos[:] = closed.qpos[0]
        if v is not None:
            data.qvel[self.robot.moving_dofs] = np.concatenate([v, closed.tangent[0] @ v])
        self.mujoco.mj_forward(self.model, data)
        self._moved = self._mass_of_axes(closed.tangent[0])

    def passive_dofs(self, unit: str) -> np.ndarray:
        passive = self.robot.moving_dofs[self.robot.n_axes :]
        return passive[[UNITS.get(int(kind)) == unit for kind in self._kinds[passive]]]

    def moved_mass(self) -> np.ndarray:
        """M + the passive joints' share, at the pose where the robot was placed last."""
        return self._moved

    def _mass_of_axes(self, tangent: np.ndarray) -> np.ndarray:
        dofs = self.robot.moving_dofs
        along = np.vstack([np.eye(self.robot.n_axes), tangent])
        return along.T @ self._full_mass()[np.ix_(dofs, dofs)] @ along

    def _full_mass(self) -> np.ndarray:
        mass = np.zeros((self.model.nv, self.model.nv))
        self.mujoco.mj_fullM(self.model, self.data, mass)
        return mass

    def add_mass(self, mass_kg: float, place_m: np.ndarray) -> None:
        m, body = self.model, self.robot.last_body
        total = m.body_mass[body] + mass_kg
        if not total > 0.0:
            raise InputError(f"--effect payload: m = {mass_kg:g} kg leaves {total:g} kg of body {m.body(body).name!r}; "
                             f"give more than {-m.body_mass[body]:g}")  # fmt: skip
        m.body_ipos[body] = (m.body_mass[body] * m.body_ipos[body] + mass_kg * np.asarray(place_m)) / total
        m.body_mass[body] = total
