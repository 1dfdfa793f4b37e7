"""A mass carried by the platform (or, on a single rotary axis, by the arm) that the model does not know."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.protocol import TakesPayload


class Payload(Effect):
    """Gravity of an extra first moment m r, in the platform frame; on one rotary axis g m r in two directions."""

    name = "payload"
    driver = "q"
    equation = "gravity of an extra first moment m r on the platform"
    hardware = "network"
    remedy = "hang a known mass on the machine and log again"
    units = {"moment": "kg m", "torque": "[f]"}  # noqa: RUF012
    per_axis = False

    def unavailable(self, data):
        is_arm = data.n_axes == 1 and data.position_units == ("rad",)
        return "" if isinstance(data.robot, TakesPayload) or is_arm else "how a payload loads the axes is not known"

    def columns(self, data, shape):
        if not isinstance(data.robot, TakesPayload):
            return {Parameter("torque_cos"): np.cos(data.q), Parameter("torque_sin"): np.sin(data.q)}
        columns = np.moveaxis(data.robot.payload_regressors(data.q), -1, 0)
        return {
            Parameter(label): column
            for label, column in zip(("moment_x", "moment_y", "moment_z"), columns, strict=True)
        }
