"""What was found in measured data, as the description of a robot in a file can have it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np


@dataclass(frozen=True)
class Mechanics:
    """All in addition to what the file has; axes and passive joints by number from 0.

    mass_kg: at the origin of the body that takes a payload; moments_kgm: first moments (3,) by body, in its frame, ""
    for the body that takes a payload; gravity_direction (3,): unit vector in the base frame, or None; friction (N or
    N m), damping (per m/s or rad/s), armature (kg or kg m^2) and springs (stiffness per m or rad, and where it is at
    rest) by axis; passive_friction (N or N m) by passive joint.
    """

    mass_kg: float = 0.0
    moments_kgm: Mapping[str, np.ndarray] = field(default_factory=dict)
    gravity_direction: np.ndarray | None = None
    friction: Mapping[int, float] = field(default_factory=dict)
    damping: Mapping[int, float] = field(default_factory=dict)
    armature: Mapping[int, float] = field(default_factory=dict)
    springs: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    passive_friction: Mapping[int, float] = field(default_factory=dict)

    def joined(self, other: "Mechanics") -> "Mechanics":
        """Both. Where both have springs of an axis, they are one that pulls alike; of directions the other's counts."""
        merged = {}
        for name in (one.name for one in fields(self)):
            mine, its = getattr(self, name), getattr(other, name)
            if isinstance(mine, Mapping):
                add = one_spring if name == "springs" else np.add
                both = {key: add(mine[key], its[key]) for key in mine.keys() & its.keys()}
                merged[name] = {**mine, **its, **both}
            elif name == "gravity_direction":
                merged[name] = mine if its is None else its
            else:
                merged[name] = mine + its
        return Mechanics(**merged)


def one_spring(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    """The spring (k, q0) that pulls, k (q - q0), as both do."""
    stiffness = first[0] + second[0]
    return stiffness, (first[0] * first[1] + second[0] * second[1]) / stiffness if stiffness else 0.0
