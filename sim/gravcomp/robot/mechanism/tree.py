"""Kinematics and weight of a tree of bodies, for many configurations at once.

Rows of a configuration (N, nq) and of a velocity (N, nv) are MuJoCo's: hinge and slide have one number, ball and free
joints a quaternion w x y z, with turning rates along the axes of their own body. MuJoCo's kinematics, in NumPy over
all poses: thousands of them take milliseconds.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gravcomp.robot.mechanism.source import MASSLESS_KG

FREE, BALL, SLIDE, HINGE = range(4)  # mujoco.mjtJoint


@dataclass(frozen=True)
class TreePose:
    """Where a tree is at N configurations, base frame, m: rotation (B, N, 3, 3) and origin (B, N, 3) of the bodies,
    axis (nv, N, 3) and anchor (nv, N, 3) of the degrees of freedom."""

    rotation: np.ndarray
    origin: np.ndarray
    axis: np.ndarray
    anchor: np.ndarray

    def point(self, body: int, local_m: np.ndarray) -> np.ndarray:
        """Base frame, (N, 3), of a point given in a body's frame."""
        return self.origin[body] + self.rotation[body] @ local_m


class Tree:
    """The tree of an mujoco.MjModel. Bodies and joints by MuJoCo's numbers; body 0 is the base."""

    def __init__(self, model):
        self.model = model
        self.bodies = [model.body(k).name for k in range(model.nbody)]
        self.joints = [model.joint(k).name for k in range(model.njnt)]
        self.parent = model.body_parentid
        mass = model.body_mass.copy()
        mass[mass <= 2 * MASSLESS_KG] = 0.0
        self.mass_kg = mass
        self.dof_joint = model.dof_jntid
        self.dof_body = model.dof_bodyid
        kinds = model.jnt_type[self.dof_joint]
        first = np.arange(model.nv) - model.jnt_dofadr[self.dof_joint]
        self.is_turning = (kinds == HINGE) | (kinds == BALL) | ((kinds == FREE) & (first >= 3))
        # [dof, body]: whether the degree of freedom moves the body.
        self.moves = np.zeros((model.nv, model.nbody), dtype=bool)
        for body in range(1, model.nbody):
            self.moves[:, body] = self.moves[:, self.parent[body]] | (self.dof_body == body)

    @cached_property
    def moved_kg(self) -> np.ndarray:
        """Mass that each degree of freedom moves, (nv,)."""
        return self.moves @ self.mass_kg

    def place(self, qpos: np.ndarray) -> TreePose:
        """All bodies and joints at configurations (N, nq)."""
        m, n = self.model, len(qpos)
        rotation, origin = np.empty((m.nbody, n, 3, 3)), np.zeros((m.nbody, n, 3))
        axis, anchor = np.empty((m.nv, n, 3)), np.empty((m.nv, n, 3))
        rotation[0] = np.eye(3)
        for body in range(1, m.nbody):
            above = self.parent[body]
            r = rotation[above] @ rotation_matrix(m.body_quat[body])
            x = origin[above] + rotation[above] @ m.body_pos[body]
            for joint in range(m.body_jntadr[body], m.body_jntadr[body] + m.body_jntnum[body]):
                r, x = self._move(joint, qpos, r, x, axis, anchor)
            rotation[body], origin[body] = r, x
        return TreePose(rotation, origin, axis, anchor)

    def _move(self, joint: int, qpos, r, x, axis, anchor):
        """Rotation and origin of a body after one of its joints; writes the joint's axes and anchors."""
        m, dof, at = self.model, self.model.jnt_dofadr[joint], self.model.jnt_qposadr[joint]
        kind, place = m.jnt_type[joint], m.jnt_pos[joint]
        if kind == FREE:
            x, r = qpos[:, at : at + 3], rotation_matrix(qpos[:, at + 3 : at + 7])
            axis[dof : dof + 3] = np.eye(3)[:, None]
            axis[dof + 3 : dof + 6] = np.moveaxis(r, 2, 0)
            anchor[dof : dof + 6] = x
            return r, x
        fixed = x + r @ place
        if kind == BALL:
            r = r @ rotation_matrix(qpos[:, at : at + 4])
            axis[dof : dof + 3] = np.moveaxis(r, 2, 0)
            anchor[dof : dof + 3] = fixed
            return r, fixed - r @ place
        travel = qpos[:, at] - m.qpos0[at]
        axis[dof], anchor[dof] = r @ m.jnt_axis[joint], fixed
        if kind == SLIDE:
            return r, x + travel[:, None] * axis[dof]
        r = r @ _turn(m.jnt_axis[joint], travel)
        return r, fixed - r @ place

    def integrate(self, qpos: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Configurations (N, nq) after a step (N, nv) of velocity times time."""
        m, moved = self.model, qpos.copy()
        for joint, kind in enumerate(m.jnt_type):
            dof, at = m.jnt_dofadr[joint], m.jnt_qposadr[joint]
            if kind in (HINGE, SLIDE):
                moved[:, at] += step[:, dof]
                continue
            if kind == FREE:
                moved[:, at : at + 3] += step[:, dof : dof + 3]
                dof, at = dof + 3, at + 3
            moved[:, at : at + 4] = _turned(qpos[:, at : at + 4], step[:, dof : dof + 3])
        return moved

    def energy(self, qpos: np.ndarray, gravity_mps2: np.ndarray) -> np.ndarray:
        """Potential energy, J, (N,): -sum m g . r, zero at the base's origin, and 1/2 k (q - q_spring)^2 of springs."""
        placement = self.place(qpos)
        at, _, stiffness = self._springs
        stretch = qpos[:, at] - self.model.qpos_spring[at]
        return -(self._first_moments(placement).sum(axis=0) @ gravity_mps2) + 0.5 * stretch**2 @ stiffness

    def gradient(self, qpos: np.ndarray, placement: TreePose, gravity_mps2: np.ndarray) -> np.ndarray:
        """Derivative of the energy along each degree of freedom, (N, nv), N or N m: the effort that holds it."""
        behind = self._first_moments(placement)
        for body in range(self.model.nbody - 1, 0, -1):
            behind[self.parent[body]] += behind[body]
        lever = behind[self.dof_body] - self.moved_kg[:, None, None] * placement.anchor
        turning = np.cross(placement.axis, lever) @ gravity_mps2
        sliding = self.moved_kg[:, None] * (placement.axis @ gravity_mps2)
        result = -np.where(self.is_turning[:, None], turning, sliding).T
        at, dof, stiffness = self._springs
        result[:, dof] += stiffness * (qpos[:, at] - self.model.qpos_spring[at])
        return result

    def point_jacobian(self, placement: TreePose, body: int, point_m: np.ndarray) -> np.ndarray:
        """Velocity of a point (N, 3), fixed to a body, per rate of each degree of freedom, (N, 3, nv)."""
        dofs = np.flatnonzero(self.moves[:, body])
        result = np.zeros((len(point_m), 3, self.model.nv))
        axis, lever = placement.axis[dofs], point_m - placement.anchor[dofs]
        velocity = np.where(self.is_turning[dofs, None, None], np.cross(axis, lever), axis)
        result[:, :, dofs] = np.moveaxis(velocity, 0, 2)
        return result

    def turning_jacobian(self, placement: TreePose, body: int) -> np.ndarray:
        """Angular velocity of a body, base frame, per rate of each degree of freedom, (N, 3, nv)."""
        turning = (self.moves[:, body] & self.is_turning)[:, None, None]
        return np.moveaxis(np.where(turning, placement.axis, 0.0), 0, 2)

    def _first_moments(self, placement: TreePose) -> np.ndarray:
        """m r of each body, kg m, (B, N, 3)."""
        centre = placement.origin + (placement.rotation @ self.model.body_ipos[:, None, :, None])[..., 0]
        return self.mass_kg[:, None, None] * centre

    @cached_property
    def _springs(self) -> tuple[np.ndarray, ...]:
        """Hinges and slides with a spring: address in qpos and in qvel, stiffness in N/m or N m/rad."""
        m = self.model
        joints = np.flatnonzero(m.jnt_stiffness > 0)
        return m.jnt_qposadr[joints], m.jnt_dofadr[joints], m.jnt_stiffness[joints]


def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """Rotation (..., 3, 3) of a quaternion (..., 4), w x y z, of any length but zero."""
    w, x, y, z = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (N, 3, 3) about a unit axis (3,) by angles (N,): Rodrigues' formula."""
    cross = np.cross(axis, np.eye(3)).T  # cross @ v = axis x v
    sine, versine = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.eye(3) + sine * cross + versine * (cross @ cross)


def _turned(quaternion: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) after a rotation vector (N, 3) in the turned frame."""
    angle = np.linalg.norm(step, axis=1, keepdims=True)
    half = np.sinc(angle / (2 * np.pi)) / 2  # sin(angle / 2) / angle
    w, x, y, z = np.moveaxis(quaternion, 1, 0)
    a = np.cos(angle[:, 0] / 2)
    b, c, d = np.moveaxis(half * step, 1, 0)
    product = [
        a * w - b * x - c * y - d * z,
        a * x + b * w + d * y - c * z,
        a * y + b * z + c * w - d * x,
        a * z - b * y + c * x + d * w,
    ]
    result = np.stack(product, axis=1)
    return result / np.linalg.norm(result, axis=1, keepdims=True)
