"""Friction in the hinges of universal joints between legs and platform, as the motors feel it."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.diagnosis.effects.passive_joint_friction import doubt_of_friction, friction_by_joint
from gravcomp.robot.protocol import HasUniversalJoints


class UniversalJointFriction(Effect):
    """J_u^T (fc sign(v_u)), v_u = J_u v over the hinges; one level for all."""

    name = "universal_joint_friction"
    driver = "dir"
    equation = "J_u^T (fc sign(v_u)), v_u = J_u v over the hinges of the universal joints"
    hardware = "compensator"
    units = {"fc_universal": "Nm"}  # noqa: RUF012
    positive = ("fc_universal", "fc_universal_nm")
    per_axis = False
    is_linear = True
    complexity = "uncommon"

    def unavailable(self, data):
        return needs_velocity(data) or (
            "" if isinstance(data.robot, HasUniversalJoints) else "the universal joints are not known"
        )

    def columns(self, data, shape):
        return {Parameter("fc_universal_nm"): data.once(_by_joint).sum(axis=1)}

    def predict(self, data, parameters):
        return np.einsum("nmk,m->nk", data.once(_by_joint), _levels(data, parameters))

    def doubt(self, data, parameters):
        levels = np.tile(_levels(data, parameters), 2)
        return doubt_of_friction(data.once(universal_jacobian), data, levels)

    def constants(self, data, parameters):
        """The Coulomb friction that is nearest to these forces in the mean square."""
        friction_n = np.mean(self.predict(data, parameters) * data.direction, axis=0)
        return {"fc_pos": friction_n, "fc_neg": friction_n}


class FrictionOfEachUniversalJoint(UniversalJointFriction):
    """The same with a level for each joint, both of its hinges alike."""

    complexity = "rare"

    def columns(self, data, shape):
        return {
            Parameter("fc_universal_nm", joint): own for joint, own in enumerate(data.once(_by_joint).swapaxes(0, 1))
        }


def universal_jacobian(data) -> np.ndarray:
    return data.robot.universal_jacobian(data.q)


def _by_joint(data) -> np.ndarray:
    """What friction of level one in both hinges of each joint adds to the axes, (n, m, k)."""
    hinges = friction_by_joint(data.once(universal_jacobian), data)
    return hinges.reshape(len(hinges), 2, -1, data.n_axes).sum(axis=1)


def _levels(data, parameters) -> np.ndarray:
    """Friction of each joint, (m,): of all, its own, or both."""
    name, n_joints = "fc_universal_nm", data.robot.universal_jacobian(data.q[:1]).shape[1] // 2
    return np.array([parameters.get(name, 0.0) + parameters.get(Parameter(name, m), 0.0) for m in range(n_joints)])
