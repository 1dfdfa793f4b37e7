"""Friction in the passive joints of a robot that has some, as the motors feel it."""

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect, needs_velocity
from gravcomp.robot.protocol import HasPassiveJoints

_ROUNDING = 1e-9  # of the speed that the axes could give a joint: less is rest


class PassiveJointFriction(Effect):
    """J_p^T (fc sign(v_p)), v_p = J_p v over the prismatic and the rotary passive joints."""

    name = "passive_joint_friction"
    driver = "dir"
    equation = "J_p^T (fc sign(v_p)), v_p = J_p v"
    hardware = "compensator"
    units = {"fc_prismatic": "N", "fc_rotary": "Nm"}  # noqa: RUF012
    positive = ("fc_prismatic", "fc_rotary")
    per_axis = False
    complexity = 2.0

    def unavailable(self, data):
        return needs_velocity(data) or (
            "" if isinstance(data.robot, HasPassiveJoints) else "the passive joints are not known"
        )

    def columns(self, data, shape):
        jacobian = data.robot.passive_jacobian(data.q)
        speed = np.einsum("npk,nk->np", jacobian, data.v)
        # where v is read on a grid, a slow joint's sign is not sure: its mean over what v may be
        unsure = np.einsum("npk,nk->np", np.abs(jacobian), data.dead_band)
        unsure += _ROUNDING * np.linalg.norm(jacobian, axis=2) * np.linalg.norm(data.v, axis=1)[:, None]
        moving = np.clip(speed / np.maximum(unsure, 1e-300), -1.0, 1.0)
        force = jacobian * moving[..., None]
        is_prismatic = np.array([unit == "m" for unit in data.robot.passive_units])
        return {
            Parameter("fc_prismatic_n"): force[:, is_prismatic].sum(axis=1),
            Parameter("fc_rotary_nm"): force[:, ~is_prismatic].sum(axis=1),
        }

    def constants(self, data, parameters):
        """The Coulomb friction that is nearest to these forces in the mean square."""
        friction_n = np.mean(self.predict(data, parameters) * data.direction, axis=0)
        return {"fc_pos": friction_n, "fc_neg": friction_n}

    def contrasts(self, labels):
        return [{label: 1.0} for label in labels]
