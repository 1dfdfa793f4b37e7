"""A robot of a URDF or MJCF file: serial or with loops, of linear and rotary axes, efforts by virtual work.

f = dV/dq along the mechanism's motions: with the gradient g of the potential energy V over all joints and
dq_p = T dq_a of the passive ones, f = g_a + T^T g_p. f_i is what motor i exerts, positive along +q_i, to hold the robot
at rest: N on a slide, N m on a hinge. Positions are those of the file's joints. Joints that are no axes and in no loop
of an axis stand still.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.fields import finite, only, text
from gravcomp.robot.mechanism.closure import Closed, Closure, driven_loops
from gravcomp.robot.mechanism.outward import holding_efforts
from gravcomp.robot.mechanism.source import compile_model, sources
from gravcomp.robot.mechanism.tree import BALL, FREE, HINGE, SLIDE, Tree, TreePose
from gravcomp.robot.protocol import Bounds, Formula, PoseError
from gravcomp.robot.ranges import (
    Box,
    Limits,
    Poses,
    Range,
    axis_entries,
    working_range,
    workspace_files,
    workspace_of,
)
from gravcomp.robot.search import effort_bounds

UNITS = {SLIDE: "m", HINGE: "rad"}
_WIDEST = {"m": 1e4, "rad": 2e3 * math.pi}  # range of an axis: ten kilometres, a thousand turns


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A serial chain, or tree, of bodies.

    axes (n,): degrees of freedom of the axes; reference (nq,): configuration of all other joints. last_body: that takes
    a payload. files: what it was read from, content by name beside robot.toml.
    """

    tree: Tree
    axes: np.ndarray
    reference: np.ndarray
    gravity_mps2: np.ndarray
    area: Box | Poses
    last_body: int
    files: Mapping[str, bytes]

    @property
    def n_axes(self) -> int:
        return len(self.axes)

    @property
    def position_units(self) -> tuple[str, ...]:
        return tuple(UNITS[int(self.tree.model.jnt_type[joint])] for joint in self.tree.dof_joint[self.axes])

    def forces(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n), N or N m, at q (..., n), m or rad. Raises PoseError where the loops do not close."""
        q = self._checked(q)
        closed = self._closed(q.reshape(-1, self.n_axes))
        gradient = self.tree.gradient(closed.qpos, self.tree.place(closed.qpos), self.gravity_mps2)
        return self._along_axes(gradient[..., None], closed)[..., 0].reshape(q.shape)

    def energy(self, q: np.ndarray) -> np.ndarray:
        """Potential energy V (...), J, of gravity and springs at q (..., n); zero at the base's origin."""
        q = self._checked(q)
        closed = self._closed(q.reshape(-1, self.n_axes))
        return self.tree.energy(closed.qpos, self.gravity_mps2).reshape(q.shape[:-1])

    def workspace(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, n) of the box of the axes' ranges, or rows of the CSV of poses."""
        return self.area.sample(n_poses, seed)

    def boundary(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, n) with one axis at an end of its range; of a list of poses any."""
        return self.area.boundary(n_poses, seed)

    @property
    def ranges(self) -> tuple[np.ndarray, np.ndarray]:
        return self.area.low, self.area.high

    @property
    def rows(self) -> np.ndarray | None:
        """All poses of the workspace (N, n) where it is a list."""
        return self.area.q if isinstance(self.area, Poses) else None

    @cached_property
    def bounds(self) -> Bounds:
        """Of efforts by a search from random poses. Raises PoseError when the workspace leaves the robot's."""
        low, high = self.area.low, self.area.high
        return Bounds(low, high, low, high, *effort_bounds(self.forces, self.area))

    def configurations(self, q: np.ndarray) -> Closed:
        """All joints at positions q (N, n), and how the passive ones move with the axes. Raises PoseError."""
        return self._closed(self._checked(q))

    @property
    def moving_dofs(self) -> np.ndarray:
        """Degrees of freedom of the axes, then those that loops tie to them."""
        return self.axes

    @property
    def gravity_direction(self) -> np.ndarray:
        return self.gravity_mps2 / np.linalg.norm(self.gravity_mps2)

    def with_gravity(self, direction: np.ndarray) -> "Mechanism":
        return replace(self, gravity_mps2=np.linalg.norm(self.gravity_mps2) * np.asarray(direction, dtype=float))

    def formula(self) -> Formula:
        """Over the positions themselves: efforts of a serial chain are polynomials of their sines and cosines.

        Raises InputError for a workspace that is a list of poses, and for ball and free joints.
        """
        if not np.isin(self.tree.model.jnt_type, list(UNITS)).all():
            raise InputError("a ball or free joint has no single coordinate; give hinges and slides")
        if isinstance(self.area, Poses):
            raise InputError('the workspace is a list of poses, not a box; give [workspace] kind = "box"')

        m = self.tree.model
        numbers = {int(joint): k for k, joint in enumerate(self.tree.dof_joint[self.axes])}
        away = self.reference[m.jnt_qposadr] - m.qpos0[m.jnt_qposadr]
        stiffness, zero = m.jnt_stiffness[[*numbers]], (m.qpos0 - m.qpos_spring)[self._places]

        def at(q):
            travel = [
                q[..., numbers[j]] - m.qpos0[m.jnt_qposadr[j]] if j in numbers else away[j] for j in range(m.njnt)
            ]
            efforts = holding_efforts(self.tree, travel, self.gravity_mps2)
            held = [efforts[j] + stiffness[k] * (travel[j] + zero[k]) for j, k in numbers.items()]
            return q, np.stack(np.broadcast_arrays(*held), axis=-1)

        return Formula(tuple(f"q{k}_{unit}" for k, unit in enumerate(self.position_units, start=1)), *self.ranges, at)

    @cached_property
    def _moved_bodies(self) -> list[int]:
        """Bodies that an axis moves, from the base outward; that which takes a payload is last."""
        moved = np.flatnonzero(self.tree.moves[self.moving_dofs].any(axis=0)).tolist()
        return [*(body for body in moved if body != self.last_body), self.last_body]

    @property
    def body_names(self) -> tuple[str, ...]:
        return tuple(self.tree.bodies[body] for body in self._moved_bodies)

    def moment_regressors(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n, b, 3) per kg m of first moment along the axes of each moved body's frame."""
        q = self._checked(q)
        closed = self._closed(q.reshape(-1, self.n_axes))
        placement = self.tree.place(closed.qpos)
        columns = [self._moment_columns(closed, placement, body) for body in self._moved_bodies]
        return np.stack(columns, axis=-2).reshape(*q.shape, len(columns), 3)

    def payload_regressors(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n, 3) per kg m of first moment along the axes of the payload body's frame."""
        q = self._checked(q)
        closed = self._closed(q.reshape(-1, self.n_axes))
        return self._moment_columns(closed, self.tree.place(closed.qpos), self.last_body).reshape(*q.shape, 3)

    def payload_mass_regressor(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n) per kg at the origin of the payload body's frame: V = -g . x."""
        q = self._checked(q)
        closed = self._closed(q.reshape(-1, self.n_axes))
        placement = self.tree.place(closed.qpos)
        motion = self.tree.point_jacobian(placement, self.last_body, placement.origin[self.last_body])
        columns = -np.einsum("c,ncv->nv", self.gravity_mps2, motion)[..., None]
        return self._along_axes(columns, closed)[..., 0].reshape(q.shape)

    def _moment_columns(self, closed: Closed, placement: TreePose, body: int) -> np.ndarray:
        """V = -g . R s of a first moment s; along a turn about a, dV = -g . (a x R s)."""
        turning = self.tree.turning_jacobian(placement, body)
        columns = np.cross(self.gravity_mps2, turning, axisb=1, axisc=2) @ -placement.rotation[body]
        return self._along_axes(columns, closed)

    def _closed(self, q: np.ndarray) -> Closed:
        qpos = np.repeat(self.reference[None], len(q), axis=0)
        qpos[:, self._places] = q
        return Closed(qpos, np.zeros((len(q), 0, self.n_axes)))

    def _along_axes(self, gradient: np.ndarray, closed: Closed) -> np.ndarray:
        """Columns (N, nv, k) over all degrees of freedom to (N, n, k) over the axes."""
        return gradient[:, self.axes]

    @property
    def _places(self) -> np.ndarray:
        return self.tree.model.jnt_qposadr[self.tree.dof_joint[self.axes]]

    def _checked(self, q: np.ndarray) -> np.ndarray:
        q = np.asarray(q, dtype=float)
        if q.shape[-1:] != (self.n_axes,):
            raise PoseError(f"joint positions have shape {q.shape}; give (..., {self.n_axes})")
        rows = np.flatnonzero(~np.isfinite(q.reshape(-1, self.n_axes)).all(axis=1))
        if rows.size:
            raise PoseError(f"pose {rows[0] + 1} is not a number; give finite joint positions", int(rows[0]))
        return q


@dataclass(frozen=True, eq=False)
class ClosedMechanism(Mechanism):
    """A mechanism with loops that the axes drive."""

    closure: Closure

    def formula(self) -> Formula:
        raise InputError("the robot has loops, which are closed by iteration: its efforts are no formula of its axes")

    @property
    def passive_units(self) -> tuple[str, ...]:
        """Of the passive hinges and slides; ball and free joints are left out."""
        return tuple(UNITS[int(self.tree.model.jnt_type[joint])] for joint in self._simple_joints[1])

    def passive_jacobian(self, q: np.ndarray) -> np.ndarray:
        """Speeds of the passive hinges and slides per speed of the axes, (..., k, n)."""
        q = self._checked(q)
        rows, _ = self._simple_joints
        tangent = self._closed(q.reshape(-1, self.n_axes)).tangent[:, rows]
        return tangent.reshape(*q.shape[:-1], len(rows), self.n_axes)

    @property
    def passive_joints(self) -> np.ndarray:
        """Numbers of the joints that passive_units are of."""
        return self._simple_joints[1]

    @property
    def _simple_joints(self) -> tuple[np.ndarray, np.ndarray]:
        joints = self.tree.dof_joint[self.closure.passive]
        rows = np.flatnonzero(np.isin(self.tree.model.jnt_type[joints], list(UNITS)))
        return rows, joints[rows]

    @property
    def moving_dofs(self) -> np.ndarray:
        return np.concatenate([self.axes, self.closure.passive])

    def _closed(self, q: np.ndarray) -> Closed:
        return self.closure.at(q)

    def _along_axes(self, gradient: np.ndarray, closed: Closed) -> np.ndarray:
        return gradient[:, self.axes] + np.swapaxes(closed.tangent, 1, 2) @ gradient[:, self.closure.passive]


def from_table(table: dict, where: str) -> Mechanism:
    """The robot of a robot.toml at the path where. Raises InputError naming table and key."""
    model, place = table["model"], f"{where}: [model]"
    only(model, place, ("kind", "file", "gravity", "payload_body", "held"))
    path = Path(where).parent / text(model, place, "file")
    tree = Tree(compile_model(path))
    entries = axis_entries(table, where)
    joints = [_joint(tree, axis, f"{where}: axis {k}") for k, axis in enumerate(entries, start=1)]
    for k, joint in enumerate(joints):
        if joint in joints[:k]:
            raise InputError(
                f"{where}: axis {k + 1}: joint {tree.joints[joint]!r} is axis {joints.index(joint) + 1} too"
            )
    limits = [joint_limits(tree, joint) for joint in joints]
    ranges = [
        working_range(axis, f"{where}: axis {k}", limit)
        for k, (axis, limit) in enumerate(zip(entries, limits, strict=True), start=1)
    ]
    axes = tree.model.jnt_dofadr[joints]
    robot = Mechanism(
        tree=tree,
        axes=axes,
        reference=_reference(tree, model.get("held", {}), joints, f"{where}: [model.held]"),
        gravity_mps2=_gravity(tree, model, place),
        area=workspace_of(table, where, ranges, tuple(limit.unit for limit in limits)),
        last_body=_last_body(tree, model, axes, place),
        files={**sources(path), **workspace_files(table, where)},
    )
    robot = _with_loops(robot, str(path))
    _check_floating(robot, str(path))
    _check_motion(robot, entries, where)
    return robot


def _with_loops(robot: Mechanism, where: str) -> Mechanism:
    loops = driven_loops(robot.tree, robot.axes, where)
    if not loops:
        return robot
    for loop in loops:
        tied = list(dict.fromkeys(robot.tree.dof_joint[loop.dofs]))
        if len(tied) > 1 and np.isin(loop.dofs, robot.axes).all():
            names = " and ".join(repr(robot.tree.joints[joint]) for joint in tied)
            raise InputError(f"{where}: a loop or mimic ties {names}, and all of them are axes; leave one out")
    closure = Closure(robot.tree, loops, robot.axes, robot.reference, where)
    return ClosedMechanism(**{**vars(robot), "reference": closure.reference}, closure=closure)


def _joint(tree: Tree, axis: Mapping, where: str) -> int:
    """Number of the joint that [[axis]] names."""
    name = text(axis, where, "joint")
    movable = [n for n, kind in zip(tree.joints, tree.model.jnt_type, strict=True) if kind in UNITS]
    if name not in movable:
        raise InputError(f"{where}: joint {name!r} is not known; give one of {', '.join(movable)}")
    return tree.joints.index(name)


def joint_limits(tree: Tree, joint: int) -> Limits:
    """What the file says of a hinge or slide; ends as far apart as in no machine, such as 1e16, stand for none."""
    m, unit = tree.model, UNITS[int(tree.model.jnt_type[joint])]
    low, high = (float(value) for value in m.jnt_range[joint])
    is_range = m.jnt_limited[joint] and 0.0 < high - low < _WIDEST[unit]
    return Limits(unit, Range(low, high) if is_range else None)


def zero_pose(tree: Tree) -> np.ndarray:
    """The file's first keyframe, or its zero, as a configuration (nq,)."""
    return (tree.model.key_qpos[0] if tree.model.nkey else tree.model.qpos0).copy()


def _reference(tree: Tree, held: Mapping, joints: list[int], where: str) -> np.ndarray:
    """The zero pose, with the joints of [model.held] where that says."""
    m, reference = tree.model, zero_pose(tree)
    if not isinstance(held, Mapping):
        raise InputError(f"{where}: give a table, joint = position")
    for name in held:
        if name not in tree.joints or m.jnt_type[tree.joints.index(name)] not in UNITS:
            raise InputError(f"{where}: joint {name!r} is not known; give one of {', '.join(tree.joints)}")
        joint = tree.joints.index(name)
        if joint in joints:
            raise InputError(f"{where}: joint {name!r} is an axis; take it out here, or there")
        reference[m.jnt_qposadr[joint]] = finite(held, where, name)
    return reference


def _gravity(tree: Tree, model: Mapping, where: str) -> np.ndarray:
    value = model.get("gravity", tree.model.opt.gravity.tolist())
    if not isinstance(value, list) or len(value) != 3:
        raise InputError(f"{where} gravity = {value!r} is not three numbers; give m/s^2 in the base frame")
    gravity = np.array([finite({"gravity": one}, where, "gravity") for one in value])
    if not gravity.any():
        raise InputError(f"{where} gravity is zero: nothing is to be held; give m/s^2 here, or in the file's <option>")
    return gravity


def last_body(tree: Tree, axes: np.ndarray) -> int:
    """The last body with a mass that the degrees of freedom axes move."""
    heavy = np.flatnonzero(tree.moves[axes].any(axis=0) & (tree.mass_kg > 0))
    return int(heavy[-1]) if heavy.size else int(tree.dof_body[axes[-1]])


def _last_body(tree: Tree, model: Mapping, axes: np.ndarray, where: str) -> int:
    """The body that takes a payload: of [model] payload_body, or the last that has mass and that an axis moves."""
    if "payload_body" not in model:
        return last_body(tree, axes)
    name = text(model, where, "payload_body")
    if name not in tree.bodies[1:]:
        raise InputError(f"{where} payload_body = {name!r} is not known; give one of {', '.join(tree.bodies[1:])}")
    return tree.bodies.index(name)


def _check_floating(robot: Mechanism, where: str) -> None:
    """A body on a free or ball joint must be held by loops."""
    m = robot.tree.model
    for joint in np.flatnonzero(np.isin(m.jnt_type, [FREE, BALL])):
        if m.jnt_dofadr[joint] not in robot.moving_dofs:
            body = robot.tree.bodies[m.jnt_bodyid[joint]]
            how = "floats" if m.jnt_type[joint] == FREE else "swings on a ball joint"
            raise InputError(f"{where}: body {body!r} {how}: no loop ties it to the axes; fix it, or close the loop")


def _check_motion(robot: Mechanism, entries: list[Mapping], where: str) -> None:
    """Every axis must move a mass. Raises InputError for one that doesn't."""
    tree, closed = robot.tree, robot._closed(robot.reference[None, robot._places])
    rates = np.eye(tree.model.nv)[robot.axes]  # [axis, dof]
    if isinstance(robot, ClosedMechanism):
        rates[:, robot.closure.passive] += closed.tangent[0].T
    # Masses that turn about their own centre count: the axis may be balanced.
    moves_mass = (np.abs(rates) > 1e-12) @ (tree.moves @ (tree.mass_kg > 0))
    for k in np.flatnonzero(~moves_mass):
        raise InputError(
            f"{where}: axis {k + 1}: joint {entries[k]['joint']!r} moves nothing that has mass; take it out, or give "
            "its bodies their masses"
        )
