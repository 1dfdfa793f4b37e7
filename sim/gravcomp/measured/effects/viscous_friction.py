"""Viscous friction."""

from gravcomp.measured.effects.base import Effect, by_axis, needs_velocity


class ViscousFriction(Effect):
    """b_i v_i."""

    name = "viscous_friction"
    equation = "b_i v_i"
    hardware = "compensator"
    units = {"b": "[f] s/[q]"}  # noqa: RUF012
    positive = ("b",)
    complexity = 1.0

    unavailable = staticmethod(needs_velocity)

    def columns(self, data, shape):
        return by_axis(data, "b", data.v)
