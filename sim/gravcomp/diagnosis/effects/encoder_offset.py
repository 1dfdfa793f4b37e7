"""The encoders' zero is not the model's."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_function


class EncoderOffset(Effect):
    """f_model(q + offset) - f_model(q)."""

    name = "encoder_offset"
    driver = "q"
    equation = "f_model(q + offset) - f_model(q)"
    hardware = "network"
    sensor = "the zero of the encoder"
    units = {"offset": "[q]"}  # noqa: RUF012
    per_axis = False
    is_curved = True
    complexity = "usual"

    unavailable = staticmethod(needs_function)

    def columns(self, data, shape):
        return {Parameter("offset", j): data.sensitivity[..., j] for j in range(data.n_axes)}

    def predict(self, data, parameters):
        offset = np.array([parameters.get(Parameter("offset", j), 0.0) for j in range(data.n_axes)])
        return data.force_at(data.q + offset) - data.modelled
