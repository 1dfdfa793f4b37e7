"""Links and joints bend under load."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_function
from gravcomp.diagnosis.thresholds import MOST_BENT, TINY


class LinkCompliance(Effect):
    """f_model(q + C f_model) - f_model(q), C diagonal and not positive: what is pushed gives way."""

    name = "link_compliance"
    driver = "f"
    equation = "f_model(q + C f) - f_model(q)"
    hardware = "network"
    units = {"c": "[q]/[f]"}  # noqa: RUF012
    per_axis = False
    is_curved = True
    complexity = "uncommon"

    unavailable = staticmethod(needs_function)

    def columns(self, data, shape):
        bent = data.sensitivity * data.nominal[:, None, :]
        return {Parameter("c", j): bent[..., j] for j in range(data.n_axes)}

    def limits_in(self, data):
        """Bending by more than a part of the axis' range is none."""
        most = MOST_BENT * np.ptp(data.q, axis=0) / np.maximum(np.abs(data.nominal).max(axis=0), TINY)
        return {Parameter("c", j): float(limit) for j, limit in enumerate(most)}

    def contrasts(self, labels):
        return [{label: -1.0} for label in labels]

    def predict(self, data, parameters):
        c = np.array([parameters.get(Parameter("c", j), 0.0) for j in range(data.n_axes)])
        return data.force_at(data.q + c * data.nominal) - data.modelled
