"""Friction in a transmission that two axes share, as in the differential of a wrist."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_velocity

_SIDES = {"plus": 1.0, "minus": -1.0}


class TransmissionFriction(Effect):
    """(fc sign(u) + b u) on both axes i and i + 1, u = v_i + v_(i+1), or u = v_i - v_(i+1) with its force on i + 1
    turned round, as virtual work has it.
    """

    name = "transmission_friction"
    driver = "dir"
    equation = "(fc_i sign(u) + b_i u) du/dv, u = v_i + v_(i+1) (plus) or v_i - v_(i+1) (minus)"
    hardware = "compensator"
    units = {f"{stem}_{side}": unit for stem, unit in (("fc", "[f]"), ("b", "[f] s/[q]")) for side in _SIDES}  # noqa: RUF012
    positive = tuple(units)
    per_axis = False
    is_linear = True
    complexity = "rarer"

    def unavailable(self, data):
        return needs_velocity(data) or ("" if _pairs(data) else "no two axes beside one another of one unit")

    def shapes(self, data):
        return [{"of": (i, side)} for i in _pairs(data) for side in _SIDES]

    def columns(self, data, shape):
        """Of the transmission that the shape names, else of all."""
        found = {}
        for i, side in [shape["of"]] if "of" in shape else [own["of"] for own in self.shapes(data)]:
            sign, both = _SIDES[side], np.zeros(data.n_axes)
            both[[i, i + 1]] = 1.0, sign
            speed, band = data.v @ both, data.dead_band @ np.abs(both)
            way = np.where(np.abs(speed) > band, np.sign(speed), 0.0)
            found[Parameter(f"fc_{side}", i)] = way[:, None] * both
            found[Parameter(f"b_{side}", i)] = speed[:, None] * both
        return found

    def groups(self, labels):
        return [{label} for label in labels]

    def constants(self, data, parameters):
        """The Coulomb friction that is nearest to these forces in the mean square."""
        friction = np.mean(self.predict(data, parameters) * data.direction, axis=0)
        return {"fc_pos": friction, "fc_neg": friction}


def _pairs(data) -> list[int]:
    """First axes of pairs that can share a transmission."""
    units = data.position_units
    return [i for i in range(data.n_axes - 1) if not units or units[i] == units[i + 1]]
