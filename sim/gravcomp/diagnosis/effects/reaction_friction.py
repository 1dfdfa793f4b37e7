"""Friction in the passive slides of a robot in proportion to what they bear: dry bearings under load."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.diagnosis.effects.passive_joint_friction import doubt_of_friction, friction_by_joint
from gravcomp.robot.protocol import KnowsReactions


class ReactionFriction(Effect):
    """J_p^T (mu r_p sign(v_p)), r_p the force across the passive slide at rest; one mu for all."""

    name = "reaction_friction"
    driver = "dir"
    equation = "J_p^T (mu abs(r_p) sign(v_p)), r_p the force across passive slide p"
    hardware = "compensator"
    units = {"mu": "1"}  # noqa: RUF012
    shared = ("mu",)
    positive = ("mu",)
    per_axis = False
    is_linear = True
    complexity = "rare"

    def unavailable(self, data):
        return needs_velocity(data) or (
            "" if isinstance(data.robot, KnowsReactions) else "what the passive slides bear is not known"
        )

    def columns(self, data, shape):
        return {Parameter("mu"): _by_slide(data).sum(axis=1)}

    def predict(self, data, parameters):
        return np.einsum("nsk,s->nk", _by_slide(data), _mu(data, parameters))

    def doubt(self, data, parameters):
        jacobian = _jacobian(data) * data.robot.slide_reactions(data.q)[..., None]
        return doubt_of_friction(jacobian, data, _mu(data, parameters))

    def constants(self, data, parameters):
        """The Coulomb friction that is nearest to these forces in the mean square."""
        friction_n = np.mean(self.predict(data, parameters) * data.direction, axis=0)
        return {"fc_pos": friction_n, "fc_neg": friction_n}


class ReactionFrictionOfEachSlide(ReactionFriction):
    """The same with a mu for each slide."""

    complexity = "rarer"

    def columns(self, data, shape):
        return {Parameter("mu", slide): own for slide, own in enumerate(_by_slide(data).swapaxes(0, 1))}


def _jacobian(data) -> np.ndarray:
    """Of the passive slides, (n, s, k)."""
    return data.robot.passive_jacobian(data.q)[:, [unit == "m" for unit in data.robot.passive_units]]


def _by_slide(data) -> np.ndarray:
    """What friction of mu = 1 in each slide adds to the axes, (n, s, k)."""
    return friction_by_joint(_jacobian(data), data) * data.robot.slide_reactions(data.q)[..., None]


def _mu(data, parameters) -> np.ndarray:
    """Of each slide, (s,): that of all, its own, or both."""
    n_slides = sum(unit == "m" for unit in data.robot.passive_units)
    return np.array([parameters.get("mu", 0.0) + parameters.get(Parameter("mu", s), 0.0) for s in range(n_slides)])
