"""Closed chains: the passive joints that close all loops for given axes, and how they move with them.

Loops are MuJoCo's equality constraints, r(q_a, q_p) = 0 with axes q_a and passive joints q_p: connect and weld between
bodies or sites, and joint. A pose is reached from the reference along a straight line of the axes: a step along the
tangent dq_p = T dq_a, T = -J_p^+ J_a, then Newton on r; a step that Newton has to mend much is halved. So a mechanism
keeps its assembly mode, and stops where it would have to pass a singularity.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.mechanism.source import engine
from gravcomp.robot.mechanism.tree import HINGE, SLIDE, Tree, TreePose, rotation_matrix
from gravcomp.robot.protocol import PoseError

_CLOSED = 1e-12  # residual, in units of the mechanism's size
_NEWTON_STEPS = 12
_RANK = 1e-7  # of the largest singular value
_LARGEST_STEP = 0.5  # of a joint along the tangent, rad or sizes
_MENDED = 0.3  # of a step along the tangent, by Newton
_SHRINKS = np.log(3.0)  # of the product of singular values in a step
_SMALLEST_STEP = 2.0**-20  # of the way from the reference
_CHUNK = 2048


@dataclass(frozen=True, eq=False)
class Loop:
    """One equality between degrees of freedom dofs: of qpos and TreePose, r (N, k) and dr per rate (N, k, nv)."""

    dofs: np.ndarray
    residual: Callable[[np.ndarray, TreePose], np.ndarray]
    jacobian: Callable[[np.ndarray, TreePose], np.ndarray]


@dataclass(frozen=True)
class Closed:
    """Closed configurations qpos (N, nq); how the passive dofs move with the axes, tangent (N, n_passive, n_axes)."""

    qpos: np.ndarray
    tangent: np.ndarray


class Closure:
    """Loops of a tree that axes drive. axes, passive: degrees of freedom given, and determined by the loops.

    reference (nq,): configuration that fixes the assembly mode; it is moved until the loops close. Raises InputError,
    with where in front, when they cannot be closed, leave joints free, or hold axes fast.
    """

    def __init__(self, tree: Tree, loops: Sequence[Loop], axes: np.ndarray, reference: np.ndarray, where: str):
        self.tree, self.loops, self.axes = tree, loops, axes
        self.passive = np.setdiff1d(np.concatenate([loop.dofs for loop in loops]), axes)
        reach = np.linalg.norm(tree.place(reference[None]).anchor[self.passive, 0], axis=-1)
        self.size = float(reach.max(initial=0.0)) or 1.0
        # Slides count in sizes of the mechanism, so that all columns of J_p are alike.
        self.unit, self.axis_unit = (np.where(tree.is_turning[dofs], 1.0, self.size) for dofs in (self.passive, axes))
        self.reference = self._close_reference(reference, where)

    def residual(self, qpos: np.ndarray, placement: TreePose) -> np.ndarray:
        """r (N, k), over the size of the mechanism."""
        return np.concatenate([loop.residual(qpos, placement) for loop in self.loops], axis=1) / self.size

    def jacobian(self, qpos: np.ndarray, placement: TreePose) -> np.ndarray:
        """dr per rate of each degree of freedom, (N, k, nv)."""
        return np.concatenate([loop.jacobian(qpos, placement) for loop in self.loops], axis=1) / self.size

    def at(self, q: np.ndarray) -> Closed:
        """Closed configurations at axes' positions q (N, n). Raises PoseError with the number of the pose."""
        parts = [self._reach(q[k : k + _CHUNK], k) for k in range(0, max(len(q), 1), _CHUNK)]
        return Closed(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def _reach(self, q: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
        way = q - self.reference[self.tree.model.jnt_qposadr[self.tree.dof_joint[self.axes]]]
        qpos = np.repeat(self.reference[None], len(q), axis=0)
        tangent, passive = self._tangent(qpos)
        done, step = np.zeros(len(q)), np.ones(len(q))
        while (left := np.flatnonzero(done < 1.0)).size:
            step[left] = np.minimum(step[left], 1.0 - done[left])
            if (stuck := left[step[left] < np.minimum(_SMALLEST_STEP, 1.0 - done[left])]).size:
                self._refuse(q, int(stuck[0]), first, done)
            moved = np.einsum("npa,na->np", tangent[left], way[left])
            largest = np.abs(np.c_[moved / self.unit, way[left] / self.axis_unit]).max(axis=1)
            step[left] = np.minimum(step[left], _LARGEST_STEP / np.maximum(largest, 1e-300))
            along = step[left, None] * way[left]
            trial, mended, is_closed = self._newton(self._stepped(qpos[left], along, step[left, None] * moved))
            is_smooth = mended <= _MENDED * step[left] * largest + 1e-6
            new_tangent, new_passive = self._tangent(trial)
            good = is_closed & is_smooth & _keeps_side(passive[left], new_passive)
            rows = left[good]
            qpos[rows], tangent[rows], passive[rows] = trial[good], new_tangent[good], new_passive[good]
            done[rows] += step[rows]
            step[left] *= np.where(good, 2.0, 0.5)
        return qpos, tangent

    def _stepped(self, qpos: np.ndarray, along: np.ndarray | float, passive: np.ndarray) -> np.ndarray:
        velocity = np.zeros((len(qpos), self.tree.model.nv))
        velocity[:, self.axes], velocity[:, self.passive] = along, passive
        return self.tree.integrate(qpos, velocity)

    def _newton(self, qpos: np.ndarray, solve=None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Configurations with passive joints moved until the loops close; largest way in all; whether they did."""
        solve = solve or _least_squares
        qpos, total, left = qpos.copy(), np.zeros((len(qpos), len(self.passive))), np.arange(len(qpos))
        is_closed = np.zeros(len(qpos), dtype=bool)
        for _ in range(_NEWTON_STEPS):
            placement = self.tree.place(qpos[left])
            residual = self.residual(qpos[left], placement)
            open_ = np.abs(residual).max(axis=1) > _CLOSED
            is_closed[left] = ~open_
            if not open_.any():
                break
            jacobian = self._passive_jacobian(qpos[left], placement)
            step = -solve(jacobian[open_], residual[open_, :, None])[..., 0]
            near = np.abs(step).max(axis=1, initial=0.0) < 1.0  # others would run away
            left, step = left[open_][near], step[near] * self.unit
            total[left] += step
            qpos[left] = self._stepped(qpos[left], 0.0, step)
        return qpos, np.abs(total / self.unit).max(axis=1, initial=0.0), is_closed

    def _passive_jacobian(self, qpos: np.ndarray, placement: TreePose) -> np.ndarray:
        return self.jacobian(qpos, placement)[..., self.passive] * self.unit

    def _tangent(self, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """T (N, n_passive, n_axes) and J_p (N, k, n_passive)."""
        jacobian = self.jacobian(qpos, self.tree.place(qpos))
        passive = jacobian[..., self.passive] * self.unit
        tangent = -_least_squares(passive, jacobian[..., self.axes]) * self.unit[:, None]
        return tangent, passive

    def _close_reference(self, reference: np.ndarray, where: str) -> np.ndarray:
        # Of the least norm, as the loops may leave joints free: that is told below.
        qpos, _, is_closed = self._newton(reference[None], lambda matrix, right: np.linalg.pinv(matrix) @ right)
        placement = self.tree.place(qpos)
        residual = self.residual(qpos, placement)[0]
        if not is_closed[0]:
            raise InputError(
                f"{where}: the loops do not close at the reference pose: {np.abs(residual).max() * self.size:.3g} m or "
                "rad are left; correct lengths or anchors, or give a keyframe where they close"
            )
        jacobian = self.jacobian(qpos, placement)[0]
        passive = jacobian[:, self.passive] * self.unit
        _, sizes, rows = np.linalg.svd(passive)
        rank = int((sizes > _RANK * sizes.max(initial=0.0)).sum())
        if rank < len(self.passive):
            free = np.flatnonzero(np.abs(rows[rank:]).max(axis=0) > 1e-3)
            names = ", ".join(dict.fromkeys(self.tree.joints[self.tree.dof_joint[self.passive[k]]] for k in free))
            raise InputError(
                f"{where}: joints {names} can move while the axes stand: the loops leave {len(self.passive) - rank} "
                "degrees of freedom open, or are singular at the reference pose; give more axes, or another keyframe"
            )
        by_axes = jacobian[:, self.axes]
        left = by_axes - passive @ np.linalg.lstsq(passive, by_axes, rcond=None)[0]
        if np.abs(left).max() > 1e-6:
            axis = int(np.abs(left).max(axis=0).argmax()) + 1
            raise InputError(
                f"{where}: the loops hold axis {axis} fast: they leave fewer degrees of freedom than there are axes; "
                "give fewer axes"
            )
        return qpos[0]

    def _refuse(self, q: np.ndarray, row: int, first: int, done: np.ndarray) -> None:
        place = ", ".join(f"{value:.6g}" for value in q[row])
        raise PoseError(
            f"pose {first + row + 1}: the loops do not close at ({place}): on the way from the reference pose they "
            f"reach a singularity, or their end, after {100 * done[row]:.0f} %; keep to this side of it",
            first + row,
        )


def _all_loops(tree: Tree, where: str) -> list[Loop]:
    """The active equalities of a model. Raises InputError for kinds that are not known."""
    mujoco = engine()
    kinds = {
        mujoco.mjtEq.mjEQ_CONNECT: _connect,
        mujoco.mjtEq.mjEQ_WELD: _weld,
        mujoco.mjtEq.mjEQ_JOINT: _coupling,
    }
    loops = []
    for k in np.flatnonzero(tree.model.eq_active0):
        kind = mujoco.mjtEq(int(tree.model.eq_type[k]))
        if kind not in kinds:
            raise InputError(
                f"{where}: equality of kind {kind.name.removeprefix('mjEQ_').lower()} is not read; give "
                "connect, weld or joint"
            )
        loops.append(kinds[kind](tree, int(k), mujoco.mjtObj.mjOBJ_SITE))
    return loops


def driven_loops(tree: Tree, axes: np.ndarray, where: str) -> list[Loop]:
    """The loops that axes move, directly or through others. Raises InputError for equalities that are not known."""
    loops, reached, driven = _all_loops(tree, where), set(axes.tolist()), set()
    while more := {k for k, loop in enumerate(loops) if k not in driven and reached & set(loop.dofs.tolist())}:
        driven |= more
        reached |= {dof for k in more for dof in loops[k].dofs.tolist()}
    return [loops[k] for k in sorted(driven)]


def _ends(tree: Tree, k: int, site) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Body, local point and local rotation of both ends of a connect or weld; engine_core_constraint.c of MuJoCo."""
    m, mujoco = tree.model, engine()
    ids, data = (m.eq_obj1id[k], m.eq_obj2id[k]), m.eq_data[k]
    if m.eq_objtype[k] == site:
        return [(m.site_bodyid[i], m.site_pos[i], rotation_matrix(m.site_quat[i])) for i in ids]
    if m.eq_type[k] == mujoco.mjtEq.mjEQ_CONNECT:
        return [(ids[0], data[0:3], np.eye(3)), (ids[1], data[3:6], np.eye(3))]
    return [(ids[0], data[3:6], rotation_matrix(data[6:10])), (ids[1], data[0:3], np.eye(3))]


def _connect(tree: Tree, k: int, site) -> Loop:
    (body, point, _), (other, other_point, _) = _ends(tree, k, site)

    def residual(qpos, placement):
        return placement.point(body, point) - placement.point(other, other_point)

    def jacobian(qpos, placement):
        ends = ((body, point), (other, other_point))
        one, two = (tree.point_jacobian(placement, b, placement.point(b, p)) for b, p in ends)
        return one - two

    return Loop(np.flatnonzero(tree.moves[:, body] ^ tree.moves[:, other]), residual, jacobian)


def _weld(tree: Tree, k: int, site) -> Loop:
    """E = R_2^T R_1 is turned away from 1 by the vector of its skew part; d of it is (tr E - E) R_2^T (w_1 - w_2)/2."""
    (body, _, turn), (other, _, other_turn) = _ends(tree, k, site)
    point = _connect(tree, k, site)

    def relative(placement):
        return np.swapaxes(placement.rotation[other] @ other_turn, 1, 2) @ placement.rotation[body] @ turn

    def residual(qpos, placement):
        e = relative(placement)
        skew = np.stack([e[:, 2, 1] - e[:, 1, 2], e[:, 0, 2] - e[:, 2, 0], e[:, 1, 0] - e[:, 0, 1]], axis=1) / 2
        # Half a turn has no skew part either.
        skew[np.einsum("nii->n", e) < 0] += 1.0
        return np.concatenate([point.residual(qpos, placement), skew], axis=1)

    def jacobian(qpos, placement):
        e, back = relative(placement), np.swapaxes(placement.rotation[other] @ other_turn, 1, 2)
        spin = back @ (tree.turning_jacobian(placement, body) - tree.turning_jacobian(placement, other))
        turning = (np.einsum("nii->n", e)[:, None, None] * spin - e @ spin) / 2
        return np.concatenate([point.jacobian(qpos, placement), turning], axis=1)

    return Loop(point.dofs, residual, jacobian)


def _coupling(tree: Tree, k: int, site) -> Loop:
    """q_1 - q_1(0) = sum_k c_k (q_2 - q_2(0))^k, or c_0 without a second joint."""
    m = tree.model
    joints = [j for j in (m.eq_obj1id[k], m.eq_obj2id[k]) if j >= 0]
    assert all(m.jnt_type[j] in (HINGE, SLIDE) for j in joints), "MuJoCo compiles no other"
    at, dofs = m.jnt_qposadr[joints], m.jnt_dofadr[joints]
    polynomial = np.polynomial.Polynomial(m.eq_data[k, :5] if len(joints) == 2 else m.eq_data[k, :1])

    def residual(qpos, placement):
        travel = qpos[:, at] - m.qpos0[at]
        return (travel[:, 0] - polynomial(travel[:, -1] if len(joints) == 2 else 0.0 * travel[:, 0]))[:, None]

    def jacobian(qpos, placement):
        rows = np.zeros((len(qpos), 1, m.nv))
        rows[:, 0, dofs[0]] = 1.0
        if len(joints) == 2:
            rows[:, 0, dofs[1]] -= polynomial.deriv()(qpos[:, at[1]] - m.qpos0[at[1]])
        return rows

    return Loop(dofs, residual, jacobian)


def _keeps_side(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Whether J_p (N, k, m) came from before to after without passing a singularity: |J_b^T J_a| keeps its sign, and
    the volume that J_p spans changes little."""
    across = np.swapaxes(before, 1, 2)
    sign, volume = np.linalg.slogdet(across @ after)
    return (sign > 0) & (np.abs(volume - np.linalg.slogdet(across @ before)[1]) <= _SHRINKS)


def _least_squares(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x of the least |matrix x - right|, batched; nan where the matrix is singular."""
    if matrix.shape[1] > matrix.shape[2]:
        transposed = np.swapaxes(matrix, 1, 2)
        matrix, right = transposed @ matrix, transposed @ right
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        determinant = np.linalg.slogdet(matrix)[0]
        result = np.full((*matrix.shape[:1], matrix.shape[2], right.shape[2]), np.nan)
        whole = determinant != 0
        result[whole] = np.linalg.solve(matrix[whole], right[whole])
        return result
