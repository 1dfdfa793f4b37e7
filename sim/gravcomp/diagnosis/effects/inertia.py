"""Mass that the model does not accelerate."""

from gravcomp.diagnosis.candidate import by_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.mechanics import Mechanics


class Inertia(Effect):
    """m_i a_i, a from the data."""

    name = "inertia"
    driver = "a"
    equation = "m_i a_i"
    hardware = "none"
    units = {"m": "[f] s^2/[q]"}  # noqa: RUF012
    complexity = "common"

    def unavailable(self, data):
        return "" if data.acceleration is not None else "no motion along time"

    def columns(self, data, shape):
        return by_axis(data, "m", data.acceleration)

    def mechanics(self, robot, parameters):
        return Mechanics(armature=dict(enumerate(per_axis(parameters, "m", robot.n_axes))))
