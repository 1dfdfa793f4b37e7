"""Which axes a robot's efforts depend on: a network need not look at the others.

The first axis of an arm on a level base bears nothing and changes nothing, and neither does a last one about which all
is balanced. Their weights would be noise of the training poses, and half of its time where they are sine and cosine.
"""

from contextlib import suppress

import numpy as np

from gravcomp.robot.protocol import PoseError, Robot

_N_POSES, _SEED = 200, 0
_NOTHING = 1e-9  # of the largest effort


def felt_axes(robot: Robot) -> np.ndarray:
    """Whether each axis (n,) changes an effort: tried by giving it the positions that it has at other poses.

    All of them where such poses cannot be told, as of a table or of axes that share a workspace, and where none does: a
    constant load.
    """
    q = robot.workspace(_N_POSES, _SEED)
    f = robot.forces(q)
    felt = np.ones(robot.n_axes, dtype=bool)
    for axis in range(robot.n_axes):
        moved = q.copy()
        moved[:, axis] = np.roll(q[:, axis], 1)
        with suppress(PoseError):
            felt[axis] = np.abs(robot.forces(moved) - f).max() > _NOTHING * np.abs(f).max()
    return felt if felt.any() else ~felt
