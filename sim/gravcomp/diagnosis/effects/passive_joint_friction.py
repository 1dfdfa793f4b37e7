"""Friction in the passive joints of a robot that has some, as the motors feel it."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.diagnosis.thresholds import AT_REST, TINY
from gravcomp.robot.mechanics import Mechanics
from gravcomp.robot.protocol import HasPassiveJoints


class PassiveJointFriction(Effect):
    """J_p^T (fc sign(v_p)), v_p = J_p v over the prismatic and the rotary passive joints."""

    name = "passive_joint_friction"
    driver = "dir"
    equation = "J_p^T (fc sign(v_p)), v_p = J_p v"
    hardware = "compensator"
    units = {"fc_prismatic": "N", "fc_rotary": "Nm"}  # noqa: RUF012
    positive = ("fc_prismatic", "fc_rotary")
    per_axis = False
    is_linear = True
    complexity = "uncommon"

    def unavailable(self, data):
        return needs_velocity(data) or (
            "" if isinstance(data.robot, HasPassiveJoints) else "the passive joints are not known"
        )

    def columns(self, data, shape):
        force = data.once(_by_joint)
        is_prismatic = _is_prismatic(data.robot)
        return {
            Parameter("fc_prismatic_n"): force[:, is_prismatic].sum(axis=1),
            Parameter("fc_rotary_nm"): force[:, ~is_prismatic].sum(axis=1),
        }

    def predict(self, data, parameters):
        return np.einsum("npk,p->nk", data.once(_by_joint), _levels(data.robot, parameters))

    def doubt(self, data, parameters):
        return doubt_of_friction(data.once(_jacobian), data, _levels(data.robot, parameters))

    def mechanics(self, robot, parameters):
        return Mechanics(passive_friction=dict(enumerate(_levels(robot, parameters))))

    def constants(self, data, parameters):
        """The Coulomb friction that is nearest to these forces in the mean square."""
        friction_n = np.mean(self.predict(data, parameters) * data.direction, axis=0)
        return {"fc_pos": friction_n, "fc_neg": friction_n}

    def contrasts(self, labels):
        return [{label: 1.0} for label in labels]


class FrictionOfEachPassiveJoint(PassiveJointFriction):
    """J_p^T (fc sign(v_p)), each passive joint with a level of its own, numbered within its kind."""

    complexity = "rare"

    def columns(self, data, shape):
        return dict(zip(_names(data.robot), data.once(_by_joint).transpose(1, 0, 2), strict=True))


def _is_prismatic(robot) -> np.ndarray:
    return np.array([unit == "m" for unit in robot.passive_units])


def _names(robot) -> list[Parameter]:
    """Parameter of the level of each passive joint."""
    is_prismatic = _is_prismatic(robot)
    number = np.where(is_prismatic, np.cumsum(is_prismatic), np.cumsum(~is_prismatic)) - 1
    stems = np.where(is_prismatic, "fc_prismatic_n", "fc_rotary_nm")
    return [Parameter(str(stem), int(own)) for stem, own in zip(stems, number, strict=True)]


def _levels(robot, parameters) -> np.ndarray:
    """Friction of each passive joint, (p,): of its kind, its own, or both."""
    names = _names(robot)
    return np.array([parameters.get(own.stem, 0.0) + parameters.get(own, 0.0) for own in names])


def friction_by_joint(jacobian, data) -> np.ndarray:
    """What friction of level one in each joint of a Jacobian (n, p, k) adds to the axes, (n, p, k)."""
    speed, unsure = _speeds(jacobian, data)
    # where v is read on a grid, a slow joint's sign is not sure: its mean over what v may be
    return jacobian * np.clip(speed / np.maximum(unsure, TINY), -1.0, 1.0)[..., None]


def _jacobian(data) -> np.ndarray:
    return data.robot.passive_jacobian(data.q)


def _by_joint(data) -> np.ndarray:
    return friction_by_joint(data.once(_jacobian), data)


def doubt_of_friction(jacobian, data, levels) -> np.ndarray:
    """How much of the force (n, k) of friction levels (p,) in the joints of a Jacobian has a sign that is not sure."""
    speed, unsure = _speeds(jacobian, data)
    return np.einsum("npk,np->nk", np.abs(jacobian), np.abs(levels * (np.abs(speed) < unsure)))


def _speeds(jacobian, data) -> tuple[np.ndarray, np.ndarray]:
    """Speeds of the joints of a Jacobian (n, p, k), and the speeds below which their sign is not sure, (n, p) each."""
    speed = np.einsum("npk,nk->np", jacobian, data.v)
    unsure = np.einsum("npk,nk->np", np.abs(jacobian), data.dead_band)
    unsure += AT_REST * np.linalg.norm(jacobian, axis=2) * np.linalg.norm(data.v, axis=1)[:, None]
    return speed, unsure
