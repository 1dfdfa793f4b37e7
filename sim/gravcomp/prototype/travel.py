"""Where a machine moves while it is measured: sides from which poses are approached, a path through its workspace."""

from typing import Protocol

import numpy as np

from gravcomp.errors import InputError
from gravcomp.prototype.sizes import reach_of
from gravcomp.robot.machine import Machine
from gravcomp.robot.protocol import HasPassiveJoints, HasRows
from gravcomp.robot.spheiro.kinematics import (
    direct_kinematics,
    inverse_kinematics,
    jacobian,
    passive_jacobian,
)
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.robot import Spheiro
from gravcomp.robot.spheiro.workspace import pose

_SIDES_TRIED = 40
# Incommensurate, so that a path comes everywhere.
_FREQUENCIES = np.array([1.0, 1.382, 0.787, 1.191, 0.618, 0.913, 1.277, 0.702])
_FILL = 0.68  # amplitude of a path: of each of two tilts, so that both together stay inside the cone
_PACE = 0.7  # of the Sphe.I.Ro.'s oscillations: long arms have more inertia for their weight
_SIDE_REACHES = 0.25 / 0.161  # by so many reaches an axis would move along a side in a radian of the platform


class Travel(Protocol):
    """Motions of one machine."""

    def rates(self, q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Speeds (n, k) of the axes at q (n, k), per rad/s of an approach, each from a side of its own."""
        ...

    def path(self, rng: np.random.Generator, phase_rad: float) -> "Path":
        """A path there and back."""
        ...


class Path(Protocol):
    def __call__(self, done: np.ndarray) -> np.ndarray:
        """Targets (n, k), m or rad, where parts 0..1 (n,) of the motion are done."""
        ...


def travel_of(machine: Machine) -> Travel:
    """Raises InputError for a robot that is but a table: nothing of it can move."""
    if isinstance(machine.robot, Spheiro):
        return SpheiroTravel(machine.robot.parameters)
    return BoxTravel(machine)


def clear_sides(maps: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Sides (n, k), of some random ones each the one that moves the slowest joint fastest: no friction's sign is in
    doubt. maps (n, joints, k): speeds of all joints per side. A joint's speed counts relative to that of all its kind.
    """
    sides = rng.standard_normal((_SIDES_TRIED, len(maps), maps.shape[2]))
    rates = np.abs(np.einsum("nji,sni->snj", maps, sides / np.linalg.norm(sides, axis=-1, keepdims=True)))
    slowest = (rates / np.maximum(np.sqrt(np.mean(rates**2, axis=(0, 1))), 1e-300)).min(axis=-1)
    return sides[slowest.argmax(axis=0), np.arange(len(maps))]


class SpheiroTravel:
    """Sides are axes that the platform turns about; a path lets two tilts and the torsion oscillate."""

    def __init__(self, p: RobotParameters):
        self._p = p

    def rates(self, q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        poses = direct_kinematics(q, self._p)
        motors = jacobian(poses, self._p)
        maps = np.concatenate([motors, passive_jacobian(poses, self._p) @ motors], axis=-2)
        return turning_rates(poses, clear_sides(maps, rng), self._p)

    def path(self, rng: np.random.Generator, phase_rad: float) -> Path:
        p, start_rad = self._p, rng.uniform(0.0, 2 * np.pi, 3)

        def targets(done):
            tilt_x, tilt_y, torsion = _FILL * np.sin(_phases(done, phase_rad, start_rad))
            tilt = np.deg2rad(p.tilt_max_deg) * np.hypot(tilt_x, tilt_y)
            rotation = pose(np.arctan2(tilt_y, tilt_x), tilt, np.deg2rad(p.torsion_max_deg) * torsion)
            return inverse_kinematics(rotation, p)

        return targets


def turning_rates(poses: np.ndarray, sides: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Speeds (n, 3) of the motors, m/s per rad/s of the platform about sides (n, 3), rotation vectors of any length."""
    units = sides / np.linalg.norm(sides, axis=-1, keepdims=True)
    return np.einsum("nij,nj->ni", jacobian(poses, p), units)


class BoxTravel:
    """Sides are directions in the space of the axes; along a path every axis oscillates in a part of its range."""

    def __init__(self, machine: Machine):
        self._machine, self._reach = machine, reach_of(machine)

    def rates(self, q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        robot, n = self._machine.robot, self._machine.n_axes
        maps = np.broadcast_to(np.diag(_SIDE_REACHES * self._reach), (len(q), n, n))
        if isinstance(robot, HasPassiveJoints):
            maps = np.concatenate([maps, robot.passive_jacobian(q) @ maps], axis=-2)
        sides = clear_sides(maps, rng)
        sides /= np.linalg.norm(sides, axis=-1, keepdims=True)
        return _SIDE_REACHES * self._reach * sides

    def path(self, rng: np.random.Generator, phase_rad: float) -> Path:
        robot, n = self._machine.robot, self._machine.n_axes
        if isinstance(robot, HasRows) and robot.rows is not None:
            raise InputError(
                f"{self._machine.where}: [workspace] is a list of poses, between which no way is known; give "
                '--mode static, or kind = "box"'
            )
        low, high = (np.array([getattr(axis, end) for axis in self._machine.axes]) for end in ("low", "high"))
        amplitude = _FILL * self._reach
        spare = np.maximum((high - low) / 2 - self._reach, 0.0)
        centre = (low + high) / 2 + rng.uniform(-spare, spare)
        start_rad = rng.uniform(0.0, 2 * np.pi, n)
        return lambda done: centre + amplitude * np.sin(_phases(done, _PACE * phase_rad, start_rad)).T


def _phases(done: np.ndarray, phase_rad: float, start_rad: np.ndarray) -> np.ndarray:
    """(k, n): up to a phase and back to the start."""
    phase = phase_rad * (1.0 - np.cos(2 * np.pi * done)) / 2
    return np.outer(_FREQUENCIES[: len(start_rad)], phase) + start_rad[:, None]
