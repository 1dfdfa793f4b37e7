"""A constant added by the current sensor or the driver."""

import numpy as np

from gravcomp.diagnosis.candidate import by_axis
from gravcomp.diagnosis.effects.base import Effect


class CurrentOffset(Effect):
    """o_i."""

    name = "current_offset"
    driver = ""
    equation = "o_i"
    hardware = "network"
    sensor = "the zero of the current sensor"
    remedy = "read the effort with the brakes engaged and the drive off: an offset is still there"
    units = {"o": "[f]"}  # noqa: RUF012
    complexity = "usual"
    is_simple = True

    def columns(self, data, shape):
        return by_axis(data, "o", np.ones(data.shape))
