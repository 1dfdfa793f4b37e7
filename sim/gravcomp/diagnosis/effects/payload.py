"""A mass carried by the last body (or, on a single rotary axis, by the arm) that the model does not know."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.mechanics import Mechanics
from gravcomp.robot.protocol import LiftsPayload, TakesPayload


class Payload(Effect):
    """Gravity of an extra first moment m r in the last body's frame, and of the mass m itself where that frame's origin
    moves; on one rotary axis g m r in two directions.
    """

    name = "payload"
    driver = "q"
    equation = "gravity of an extra mass m and first moment m r on the last body"
    hardware = "network"
    remedy = "hang a known mass on the machine and log again"
    units = {"mass": "kg", "moment": "kg m", "torque": "[f]"}  # noqa: RUF012
    shared = ("mass",)
    positive = ("mass",)  # a tool that is lighter than its model is a moment of the body, not a load
    per_axis = False

    def unavailable(self, data):
        is_arm = data.n_axes == 1 and data.position_units == ("rad",)
        return "" if isinstance(data.robot, TakesPayload) or is_arm else "how a payload loads the axes is not known"

    def columns(self, data, shape):
        if not isinstance(data.robot, TakesPayload):
            return {Parameter("torque_cos"): np.cos(data.q), Parameter("torque_sin"): np.sin(data.q)}
        columns = np.moveaxis(data.once(_moments), -1, 0)
        felt = {Parameter(f"moment_{axis}"): column for axis, column in zip("xyz", columns, strict=True)}
        if isinstance(data.robot, LiftsPayload):
            felt[Parameter("mass")] = data.once(_mass)
        return felt

    def mechanics(self, robot, parameters):
        moment = np.array([parameters.get(f"moment_{axis}", 0.0) for axis in "xyz"])
        return Mechanics(mass_kg=parameters.get("mass", 0.0), moments_kgm={"": moment})


def _moments(data) -> np.ndarray:
    return data.robot.payload_regressors(data.q)


def _mass(data) -> np.ndarray:
    return data.robot.payload_mass_regressor(data.q)
