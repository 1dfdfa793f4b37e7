"""Parameters of the Sphe.I.Ro., read from the tables [model.*] and [workspace] of robot.toml.

Source of the nominal values: ``weights/spheiro/robot.toml``, which states units and origin.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from gravcomp.errors import InputError

_SCALARS = {
    "d_m": ("model.geometry", "d_m"),
    "carriage_mass_kg": ("model.carriage", "mass_kg"),
    "link1_mass_kg": ("model.link1", "mass_kg"),
    "link1_com_m": ("model.link1", "com_m"),
    "link2_mass_kg": ("model.link2", "mass_kg"),
    "link2_com_m": ("model.link2", "com_m"),
    "platform_mass_kg": ("model.platform", "mass_kg"),
    "g_mps2": ("model.gravity", "g_mps2"),
    "tilt_max_deg": ("workspace", "tilt_max_deg"),
    "torsion_max_deg": ("workspace", "torsion_max_deg"),
}
_VECTORS = {"platform_com_m": ("model.platform", "com_m"), "gravity_direction": ("model.gravity", "direction")}
_MUST_BE_POSITIVE = {"d_m"}


@dataclass(frozen=True)
class RobotParameters:
    """Geometry, masses, gravity and workspace of the 3-CPU robot. SI units, angles of the workspace in degrees.

    ``platform_com_m`` is in the platform frame, ``gravity_direction`` a unit vector in the base frame.
    """

    d_m: float
    carriage_mass_kg: float
    link1_mass_kg: float
    link1_com_m: float
    link2_mass_kg: float
    link2_com_m: float
    platform_mass_kg: float
    platform_com_m: np.ndarray = field(repr=False)
    g_mps2: float
    gravity_direction: np.ndarray = field(repr=False)
    tilt_max_deg: float
    torsion_max_deg: float

    @property
    def gravity_mps2(self) -> np.ndarray:
        """Acceleration of gravity in the base frame, shape (3,), m/s^2."""
        return self.g_mps2 * self.gravity_direction


def parameters_from_table(table: dict, where: str) -> RobotParameters:
    """Build RobotParameters from the tables of a parsed TOML document; ``where`` names it in errors (InputError)."""
    values = {name: _scalar(table, where, name, *place) for name, place in _SCALARS.items()}
    values |= {name: _vector(table, where, *place) for name, place in _VECTORS.items()}
    values["gravity_direction"] /= max(np.abs(values["gravity_direction"]).max(), 1.0)  # else its square may overflow
    norm = float(np.linalg.norm(values["gravity_direction"]))
    if norm == 0.0:
        raise InputError(f"{where}: [model.gravity] direction has zero length; give the direction in which things fall")
    values["gravity_direction"] = values["gravity_direction"] / norm
    return RobotParameters(**values)


def _entry(table: dict, where: str, section: str, key: str):
    try:
        for name in section.split("."):
            table = table[name]
        return table[key]
    except (KeyError, TypeError):
        raise InputError(f"{where}: [{section}] {key} is missing; add it") from None


def _scalar(table: dict, where: str, name: str, section: str, key: str) -> float:
    value = _entry(table, where, section, key)
    if not _is_finite_number(value):
        raise InputError(f"{where}: [{section}] {key} = {value!r} is not a finite number; give one")
    if value < 0 or (value == 0 and name in _MUST_BE_POSITIVE):
        raise InputError(f"{where}: [{section}] {key} = {value!r} is out of range; give a positive number")
    return float(value)


def _vector(table: dict, where: str, section: str, key: str) -> np.ndarray:
    value = _entry(table, where, section, key)
    if not isinstance(value, list) or len(value) != 3 or not all(map(_is_finite_number, value)):
        raise InputError(f"{where}: [{section}] {key} = {value!r} is not three finite numbers; give three")
    return np.array(value, dtype=float)


def _is_finite_number(value) -> bool:
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # an integer beyond the floats
        return False
