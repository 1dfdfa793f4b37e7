"""Friction of a gear by what drives what: the motor the load, or the load the motor."""

import numpy as np

from gravcomp.diagnosis.candidate import by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity


class DirectionalLoadFriction(Effect):
    """mu |f_model| sign(v), mu_motor where f_model v > 0 (the motor drives), mu_load where f_model v < 0.

    M5 of Duclusaud, Passault, Padois, Ly: Extended friction models for the physics simulation of servo actuators, 2024.
    """

    name = "directional_load_friction"
    driver = "f"
    equation = (
        "(mu_i abs(f_model_i) + nu_i f_model_i^2) sign(v_i), motor and load side apart by the sign of f_model_i v_i"
    )
    hardware = "compensator"
    remedy = "hang a known mass on the machine and log again"
    units = {"mu_motor": "1", "mu_load": "1", "nu_motor": "1/[f]", "nu_load": "1/[f]"}  # noqa: RUF012
    positive = ("mu_motor", "mu_load")
    special_case = "load_dependent_friction"
    complexity = "rare"

    def unavailable(self, data):
        return needs_velocity(data) or ("" if np.any(data.nominal) else "the model is zero")

    def same_as(self, parameters):
        """Without squares it is friction of the mean of both and a gain of half their difference."""
        has_square = any(name.startswith("nu_") for name in parameters)
        return () if has_square else (self.special_case, "thrust_constant")

    def columns(self, data, shape):
        load = np.abs(data.nominal) * data.direction
        return _by_side(data, "mu", load)

    def constants(self, data, parameters):
        """The mean of both sides, which is what the compensator has."""
        motor, load = (per_axis(parameters, f"mu_{side}", data.n_axes) for side in ("motor", "load"))
        return {"mu": 0.5 * (motor + load)}


class QuadraticLoadFriction(DirectionalLoadFriction):
    """The same with the square of the load beside it, M6 of that paper."""

    complexity = "general"
    positive = ("mu_motor", "mu_load", "nu_motor", "nu_load")  # else a saturation of the effort, f |f|, would be one

    def columns(self, data, shape):
        return super().columns(data, shape) | _by_side(data, "nu", data.nominal**2 * data.direction)


def _by_side(data, stem: str, force: np.ndarray) -> dict:
    is_motor = data.nominal * data.direction > 0.0
    return by_axis(data, f"{stem}_motor", force * is_motor) | by_axis(data, f"{stem}_load", force * ~is_motor)
