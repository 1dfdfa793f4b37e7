"""What a robot is to the rest of the package: positions to efforts, over a workspace.

A robot of another package registers its kind under the entry point ``gravcomp.robots``: a callable that takes the
tables of robot.toml and the path of that file, for messages and for files beside it, and returns a Robot.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from gravcomp.errors import InputError


class PoseError(InputError):
    """A pose that the robot cannot take. index: which of several, or None."""

    def __init__(self, message: str, index: int | None = None):
        super().__init__(message)
        self.index = index


@dataclass(frozen=True)
class Bounds:
    """Bounds over the whole workspace, (n,) each, in m or rad and N or Nm.

    q_low, q_high: rounded outward, what an axis' range is unless robot.toml gives another; q_least, q_most: what the
    workspace reaches; f_low, f_high: of the efforts, rounded outward.
    """

    q_low: np.ndarray
    q_high: np.ndarray
    q_least: np.ndarray
    q_most: np.ndarray
    f_low: np.ndarray
    f_high: np.ndarray


class Robot(Protocol):
    """Statics of n axes. Positions in position_units, m or rad per axis; efforts in N for m, Nm for rad."""

    @property
    def n_axes(self) -> int: ...

    @property
    def position_units(self) -> tuple[str, ...]: ...

    @property
    def bounds(self) -> Bounds: ...

    def forces(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n) of the motors that hold the robot at rest at q (..., n).

        Raises PoseError where the robot cannot be.
        """
        ...

    def workspace(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, n) drawn from the workspace."""
        ...


@runtime_checkable
class HasRanges(Protocol):
    """Knows the ranges of its axes without its bounds, which may take a search."""

    @property
    def ranges(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest position of each axis, (n,) each, m or rad, unless robot.toml gives others."""
        ...


@runtime_checkable
class ReadsFiles(Protocol):
    """Is described by files beside robot.toml: they belong to the machine folder and to its hash."""

    @property
    def files(self) -> Mapping[str, bytes]:
        """Content by name, relative to the folder of robot.toml."""
        ...


@runtime_checkable
class HasRows(Protocol):
    """May have a workspace that is a list of poses: some of them are kept from training, to test on."""

    @property
    def rows(self) -> np.ndarray | None:
        """All poses of the workspace (N, n), or None where it is no list."""
        ...


@runtime_checkable
class HasBoundary(Protocol):
    """Knows where its workspace ends: there a network errs most."""

    def boundary(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, n) drawn from the boundary of the workspace."""
        ...


@runtime_checkable
class TakesOrientations(Protocol):
    """Is told where to go as the orientation of its last body, too."""

    @property
    def orientation_names(self) -> tuple[str, ...]:
        """Of the angles, in their order."""
        ...

    def at_orientation(self, angles_rad: np.ndarray) -> np.ndarray:
        """Positions (..., n) at angles (..., k). Raises PoseError outside the workspace."""
        ...


@runtime_checkable
class TellsOrientation(TakesOrientations, Protocol):
    """And tells the orientation at which it is: maps are drawn over it."""

    def orientation(self, q: np.ndarray) -> np.ndarray:
        """Angles (..., k), rad, at positions (..., n); the inverse of at_orientation. Raises PoseError."""
        ...


@runtime_checkable
class TurnsGravity(Protocol):
    """Can tell what it holds when gravity has another direction: its base is not level."""

    @property
    def gravity_direction(self) -> np.ndarray:
        """Unit vector (3,) in the base frame."""
        ...

    def with_gravity(self, direction: np.ndarray) -> Robot:
        """The same robot, gravity along the unit vector direction (3,)."""
        ...


@runtime_checkable
class TakesPayload(Protocol):
    """Can tell what an extra first moment on its last body adds."""

    def payload_regressors(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n, 3) per kg m of first moment along the axes of that body's frame."""
        ...


@runtime_checkable
class LiftsPayload(TakesPayload, Protocol):
    """The origin of its last body moves: an extra mass there is felt, whatever its first moment."""

    def payload_mass_regressor(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n) per kg at the origin of that body's frame."""
        ...


@runtime_checkable
class HasBodies(Protocol):
    """Can tell what an extra first moment on any of its bodies adds; the last one is that which takes a payload."""

    @property
    def body_names(self) -> tuple[str, ...]:
        """From the base outward."""
        ...

    def moment_regressors(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n, b, 3) per kg m of first moment along the axes of each of the b bodies' frames."""
        ...


@runtime_checkable
class HasPassiveJoints(Protocol):
    """Has joints without a motor."""

    @property
    def passive_units(self) -> tuple[str, ...]:
        """m or rad per passive joint."""
        ...

    def passive_jacobian(self, q: np.ndarray) -> np.ndarray:
        """J_p (..., k, n): speeds of the k passive joints per speed of the axes."""
        ...


@runtime_checkable
class KnowsReactions(HasPassiveJoints, Protocol):
    """Can tell what its passive slides bear."""

    def slide_reactions(self, q: np.ndarray) -> np.ndarray:
        """Force across each passive joint of unit m, N, (..., s), in the order of the passive joints."""
        ...


@runtime_checkable
class HasUniversalJoints(Protocol):
    """Has universal joints between its legs and its platform: hinges (inner_1, .., inner_m, outer_1, .., outer_m)."""

    def universal_angles(self, q: np.ndarray) -> np.ndarray:
        """(..., 2 m), rad, zero at home."""
        ...

    def universal_jacobian(self, q: np.ndarray) -> np.ndarray:
        """J_u (..., 2 m, n): speeds of the hinges per speed of the axes."""
        ...


@dataclass(frozen=True)
class Formula:
    """Statics as arithmetic over a box of k parameters, low to high (k,), that covers the workspace.

    at: parameters (..., k) to positions (..., n) and efforts (..., n); floats, or objects of any number type that has
    +, -, *, /, sqrt, sin and cos.
    """

    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@runtime_checkable
class HasFormula(Protocol):
    """Can tell its efforts by arithmetic alone, without a search or an iteration."""

    def formula(self) -> Formula:
        """Raises InputError where this robot has none."""
        ...
