"""A robot's cyclic symmetry: turning the axes 1 -> 2 -> ... -> n -> 1 turns the efforts with them.

f(P q) = P f(q) with P the cyclic permutation of axes. Three-fold on a Sphe.I.Ro. whose masses, gravity and workspace
are symmetric about (1,1,1).
"""

import numpy as np

from gravcomp.robot.protocol import PoseError, Robot

_TOLERANCE = 1e-8  # of the largest effort


def is_cyclic(robot: Robot) -> bool:
    """Whether the robot's efforts have the symmetry, tried at random poses."""
    if robot.n_axes < 2 or len(set(robot.position_units)) > 1:
        return False
    q = robot.workspace(20, 0)
    wanted = np.roll(robot.forces(q), 1, axis=-1)
    try:
        turned = robot.forces(np.roll(q, 1, axis=-1))
    except PoseError:
        return False
    return bool(np.abs(turned - wanted).max() <= _TOLERANCE * np.abs(wanted).max())


def cyclic_images(values: np.ndarray) -> np.ndarray:
    """Rows (N, n) and their n - 1 cyclic permutations, (n N, n): the same poses, seen from every axis."""
    return np.concatenate([np.roll(values, k, axis=1) for k in range(values.shape[1])])


def cyclic_tie(n_hidden: int, n_axes: int) -> np.ndarray:
    """Tie under which a network has the symmetry exactly, for ``levenberg_marquardt.Problem``.

    Neurons come in orbits of n_axes whose weights are permutations of one another; neurons left over are their own
    image, with equal weights for every axis.
    """
    n_orbits, n_alone = divmod(n_hidden, n_axes)
    axis = np.arange(n_axes)
    turn = (axis[None, :] - axis[:, None]) % n_axes  # [member of the orbit, input]
    hidden = [
        np.c_[turn + orbit * (n_axes + 1), np.full(n_axes, orbit * (n_axes + 1) + n_axes)] for orbit in range(n_orbits)
    ]
    first = n_orbits * (n_axes + 1)
    hidden += [np.array([[first + 2 * k] * n_axes + [first + 2 * k + 1]]) for k in range(n_alone)]
    output = [turn + orbit * n_axes for orbit in range(n_orbits)]  # [output, member of the orbit]: V turns with W
    output += [np.full((n_axes, 1), n_orbits * n_axes + k) for k in range(n_alone + 1)]  # the last one is b_o
    n_free_hidden = first + 2 * n_alone
    return np.concatenate([np.vstack(hidden).ravel(), np.hstack(output).ravel() + n_free_hidden])
