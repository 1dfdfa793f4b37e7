"""Where a campaign goes: poses to hold, each from two sides, and slow legs there and back; a part of both is held out.

Everything is in counts, as the core takes it, and follows from machine, sizes and seed alone: a campaign that was
stopped goes on along the same route.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.machine import Machine

HOLD, LEG = "hold", "leg"
ONE_IN = 4  # of holds, and of legs, is held out: no fit sees it, and it is measured again at the end
_SIDE = 0.01  # of the range of an axis: how far beside a pose its approaches begin
_SIDE_SPREAD = (0.5, 1.0)  # of that, drawn by axis
LEAST_HOLDS, LEAST_LEGS = 2 * ONE_IN, 2


@dataclass(frozen=True)
class Step:
    """One place to hold, between the ends of its approaches, or one leg. counts per axis.

    ends: of the approaches, from which the robot comes to the pose, or of the leg, which it goes there and back.
    seconds: of an approach, or of a way of the leg; None: slowly, as the campaign does.
    """

    kind: str
    number: int
    pose: tuple[int, ...]
    ends: tuple[tuple[int, ...], tuple[int, ...]]
    is_held_out: bool
    seconds: float | None = None


def route(machine: Machine, n_holds: int, n_legs: int, seed: int, given: np.ndarray | None = None) -> list[Step]:
    """Steps for a machine: holds drawn from its workspace, each next to the one before, then legs across it.

    given: poses to hold instead of drawn ones (n_holds, k), m or rad, in their order. Raises InputError for too few.
    """
    if n_holds < LEAST_HOLDS or n_legs < LEAST_LEGS:
        raise InputError(f"{n_holds} poses and {n_legs} legs: need {LEAST_HOLDS} and {LEAST_LEGS} at least")
    rng = np.random.default_rng([seed, 53])
    poses = _tour(machine, machine.robot.workspace(n_holds, seed)) if given is None else given
    low, high = (np.array([getattr(axis, name) for axis in machine.axes]) for name in ("low", "high"))
    # From both ends an approach stays within the range of its axis.
    sides = _SIDE * (high - low) * rng.uniform(*_SIDE_SPREAD, poses.shape) * rng.choice([-1, 1], poses.shape)
    poses = np.clip(poses, low + np.abs(sides), high - np.abs(sides))
    holds = [_hold(machine, number, *place) for number, place in enumerate(zip(poses, sides, strict=True))]
    # Consecutive poses are neighbours; a leg crosses the workspace.
    ends = _tour(machine, machine.robot.workspace(n_legs + 1, seed + 1), nearest=False)
    return holds + [_leg(machine, number, ends[number : number + 2]) for number in range(n_legs)]


def _hold(machine: Machine, number: int, pose: np.ndarray, side: np.ndarray) -> Step:
    ends = _counts(machine, pose - side), _counts(machine, pose + side)
    return Step(HOLD, number, _counts(machine, pose), ends, number % ONE_IN == ONE_IN - 1)


def _leg(machine: Machine, number: int, ends: np.ndarray) -> Step:
    there, back = (_counts(machine, end) for end in ends)
    return Step(LEG, number, there, (there, back), number % ONE_IN == 1)


def _counts(machine: Machine, q: np.ndarray) -> tuple[int, ...]:
    return tuple(machine.drive.counts(q).tolist())


def _tour(machine: Machine, poses: np.ndarray, nearest: bool = True) -> np.ndarray:
    """Poses (n, k) in an order in which the next one is always the nearest, or the farthest, that is left."""
    size = np.array([axis.high - axis.low for axis in machine.axes])
    left, order = list(range(1, len(poses))), [0]
    while left:
        ways = np.abs((poses[left] - poses[order[-1]]) / size).max(axis=1)
        order.append(left.pop(int(ways.argmin() if nearest else ways.argmax())))
    return poses[order]


def longest_way(start: Sequence[int], end: Sequence[int]) -> int:
    """Counts of the axis that goes farthest."""
    return max(abs(a - b) for a, b in zip(start, end, strict=True))
