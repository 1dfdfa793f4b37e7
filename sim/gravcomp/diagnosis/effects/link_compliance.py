"""Links and joints bend under load."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_function


class LinkCompliance(Effect):
    """f_model(q + C f_model) - f_model(q), C diagonal."""

    name = "link_compliance"
    driver = "f"
    equation = "f_model(q + C f) - f_model(q)"
    hardware = "network"
    units = {"c": "[q]/[f]"}  # noqa: RUF012
    per_axis = False
    complexity = 2.0

    unavailable = staticmethod(needs_function)

    def columns(self, data, shape):
        bent = data.sensitivity * data.nominal[:, None, :]
        return {Parameter("c", j): bent[..., j] for j in range(data.n_axes)}

    def predict(self, data, parameters):
        c = np.array([parameters.get(Parameter("c", j), 0.0) for j in range(data.n_axes)])
        return data.force_at(data.q + c * data.nominal) - data.modelled
