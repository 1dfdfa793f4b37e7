"""Limits and gains of a machine at a core that is slowed down: the TOML file that a user would write."""

import numpy as np

from gravcomp.prototype.engine import SERVO_PER_KG, TIME_STEP_S
from gravcomp_lab.cosim.library import EDGE_CLOCKS
from gravcomp_lab.cosim.world import World

_FILTER = 2
_CURRENT_A_PER_STALL = 3.0  # of the largest effort of the workspace
_FASTEST = 0.97  # of what an encoder can tell


def limits_toml(world: World) -> str:
    """For the machine of a world: a servo with the poles of the prototype's at each axis' own mass, limits that its
    motion keeps.
    """
    drive, robot = world.machine.drive, world.machine.robot
    fastest = _FASTEST * drive.clock_hz / EDGE_CLOCKS
    ua_per_unit = 1e6 / drive.effort_per_ampere
    kp, ki, kd = (gain * np.diag(world.plant.engine.moved_mass()) * drive.unit_per_count * ua_per_unit
                  for gain in SERVO_PER_KG)  # fmt: skip
    largest_ua = np.maximum(np.abs(robot.bounds.f_low), np.abs(robot.bounds.f_high)) * ua_per_unit
    limit = np.rint(_CURRENT_A_PER_STALL * largest_ua).astype(int).tolist()
    values = {
        "index_position": world.index.tolist(),
        "margin_counts": 3000,
        "speed_max_counts_per_s": round(fastest),
        "current_limit_ua": limit,
        "current_slew_ua": limit,
        "command_bound_ua": limit,
        "tick_us": round(1e6 * TIME_STEP_S),
        "saturation_us": 2_000_000,
        "watchdog_us": 2_000_000,
        "result_us": 10_000,
        "brake_us": 20_000,
        "command_us": 100_000,
        "hold_us": 500_000,
    }
    motion = {
        "stiffness_ua_per_count": kp.tolist(),
        "integral_ua_per_count_s": ki.tolist(),
        "damping_ua_s_per_count": kd.tolist(),
        "filter": _FILTER,
        "speed_feed_forward": "true",
        "servo_limit_ua": limit,
        "following_counts": 2000,
        "speed_counts_per_s": round(0.8 * fastest),
        "acceleration_counts_per_s2": round(8 * fastest),
    }
    lines = [f"{name} = {value}" for name, value in values.items()]
    return "\n".join([*lines, "", "[motion]", *(f"{name} = {value}" for name, value in motion.items())]) + "\n"
