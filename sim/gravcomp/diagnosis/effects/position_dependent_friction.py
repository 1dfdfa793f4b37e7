"""Coulomb friction that changes along the travel: a seal, a misaligned guide, a cable that winds up."""

from gravcomp.diagnosis.candidate import Parameter, on_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity


class PositionDependentFriction(Effect):
    """(fc_i + slope_i q_i) sign(v_i)."""

    name = "position_dependent_friction"
    driver = "dir"
    equation = "(fc_i + slope_i q_i) sign(v_i)"
    hardware = "compensator"
    units = {"fc": "[f]", "slope": "[f]/[q]"}  # noqa: RUF012
    special_case = "coulomb_friction"
    complexity = "rare"

    unavailable = staticmethod(needs_velocity)

    def columns(self, data, shape):
        out = {}
        for i in range(data.n_axes):
            out[Parameter("fc", i)] = on_axis(data, i, data.direction[:, i])
            out[Parameter("slope", i)] = on_axis(data, i, data.q[:, i] * data.direction[:, i])
        return out

    def constants(self, data, parameters):
        """Its mean over the positions in the data: the compensator's friction knows no position."""
        fc, slope = (per_axis(parameters, stem, data.n_axes) for stem in ("fc", "slope"))
        mean = fc + slope * data.q.mean(axis=0)
        return {"fc_pos": mean, "fc_neg": mean}
