"""Efforts that hold a tree of hinges and slides, in the frames of its bodies, for numbers of any type.

``Tree`` works in the base frame, where every body's place holds the angles of all joints before it. Here gravity goes
outward into each body's frame, first moments come inward, and an effort is their product at the joint: no angle enters
a factor twice, a joint that does not tilt gravity enters nowhere. Intervals stay as narrow as they can.

f_j = -g . (a x (S - M p)) of a hinge with axis a at p, -M g . a of a slide: g gravity, M and S mass and first moment of
all that the joint moves, about the origin of its body, in that body's frame.
"""

from collections.abc import Sequence

import numpy as np

from gravcomp.robot.mechanism.tree import HINGE, Tree, rotation_matrix


def holding_efforts(tree: Tree, travel: Sequence, gravity_mps2: np.ndarray) -> list:
    """Effort of each joint, N or N m, when joint j is travel[j] (any shape (...), number or objects) from the file's
    zero. All joints are hinges or slides; springs are not in it."""
    m = tree.model
    gravity, turns, efforts = [gravity_mps2], {}, [0.0] * m.njnt
    for body in range(1, m.nbody):
        g = gravity[tree.parent[body]] @ rotation_matrix(m.body_quat[body])
        for joint in _joints(tree, body):
            turns[joint] = np.cos(travel[joint]), np.sin(travel[joint])
            if m.jnt_type[joint] == HINGE:
                g = _turned(m.jnt_axis[joint], turns[joint][0], -turns[joint][1], g)
        gravity.append(g)
    mass = tree.mass_kg.copy()
    moment = list(mass[:, None] * m.body_ipos)
    for body in range(m.nbody - 1, 0, -1):
        g, s = gravity[body], moment[body]
        for joint in reversed(_joints(tree, body)):
            axis, place = m.jnt_axis[joint], m.jnt_pos[joint]
            if m.jnt_type[joint] == HINGE:
                lever = s - mass[body] * place
                efforts[joint] = -(np.cross(axis, lever) * g).sum(axis=-1)
                s = _turned(axis, *turns[joint], lever) + mass[body] * place
                g = _turned(axis, *turns[joint], g)
            else:
                efforts[joint] = -mass[body] * (axis * g).sum(axis=-1)
                s = s + np.asarray(travel[joint])[..., None] * (mass[body] * axis)
        parent = tree.parent[body]
        mass[parent] += mass[body]
        moment[parent] = moment[parent] + s @ rotation_matrix(m.body_quat[body]).T + mass[body] * m.body_pos[body]
    return efforts


def _joints(tree: Tree, body: int) -> range:
    first = tree.model.body_jntadr[body]
    return range(first, first + tree.model.body_jntnum[body])


def _turned(axis: np.ndarray, cosine, sine, v: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) turned about a unit axis: a (a . v) + cos (v - a (a . v)) + sin a x v."""
    along = axis * (axis * v).sum(axis=-1, keepdims=True)
    return along + np.asarray(cosine)[..., None] * (v - along) + np.asarray(sine)[..., None] * np.cross(axis, v)
