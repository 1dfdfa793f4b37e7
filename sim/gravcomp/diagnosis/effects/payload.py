"""A mass carried by the platform (or, on a single rotary axis, by the arm) that the model does not know."""

from dataclasses import replace

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.spheiro.statics import holding_forces_at


class Payload(Effect):
    """Gravity of an extra first moment m r, in the platform frame; on one rotary axis g m r in two directions."""

    name = "payload"
    driver = "q"
    equation = "gravity of an extra first moment m r on the platform"
    hardware = "network"
    units = {"moment": "kg m", "torque": "[f]"}  # noqa: RUF012
    per_axis = False

    def unavailable(self, data):
        is_arm = data.n_axes == 1 and data.position_units == ("rad",)
        return "" if data.robot is not None or is_arm else "how a payload loads the axes is not known"

    def columns(self, data, shape):
        if data.robot is None:
            return {Parameter("torque_cos"): np.cos(data.q), Parameter("torque_sin"): np.sin(data.q)}
        empty = replace(data.robot, carriage_mass_kg=0.0, link1_mass_kg=0.0, link2_mass_kg=0.0, platform_mass_kg=1.0)
        units = zip(("moment_x", "moment_y", "moment_z"), np.eye(3), strict=True)
        return {
            Parameter(label): holding_forces_at(data.q, replace(empty, platform_com_m=unit)) for label, unit in units
        }
