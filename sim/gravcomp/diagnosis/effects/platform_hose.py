"""A hose or a cable bundle to the platform, which twists where the universal joints turn."""

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.effects.universal_joint_friction import universal_jacobian
from gravcomp.robot.protocol import HasUniversalJoints


class PlatformHose(Effect):
    """J_u^T (k phi_u): a spring, relaxed at home, about the outer hinge of each universal joint."""

    name = "platform_hose"
    driver = "q"
    equation = "J_u^T (k_i phi_u_i), phi_u_i the angle of the outer hinge of universal joint i"
    hardware = "network"
    units = {"k": "Nm/rad"}  # noqa: RUF012
    per_axis = False
    complexity = "uncommon"

    def unavailable(self, data):
        return "" if isinstance(data.robot, HasUniversalJoints) else "the universal joints are not known"

    def columns(self, data, shape):
        angles, jacobian = data.once(_angles), data.once(universal_jacobian)
        n_joints = angles.shape[1] // 2
        outer = range(n_joints, 2 * n_joints)
        return {Parameter("k", m): angles[:, [a]] * jacobian[:, a] for m, a in enumerate(outer)}

    def groups(self, labels):
        return [{label} for label in labels]


def _angles(data):
    return data.robot.universal_angles(data.q)
