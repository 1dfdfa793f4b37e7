"""The base stands askew: gravity points elsewhere in its frame. A turn about gravity itself cannot be seen."""

import numpy as np
from scipy.spatial.transform import Rotation

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.mechanics import Mechanics
from gravcomp.robot.protocol import Robot, TurnsGravity


class BaseTilt(Effect):
    """f_model with gravity turned by a small rotation tilt_a, tilt_b, rad, about two axes perpendicular to it."""

    name = "base_tilt"
    driver = "q"
    equation = "f_model with gravity turned by a small rotation, less f_model"
    hardware = "network"
    units = {"tilt": "rad"}  # noqa: RUF012
    per_axis = False
    is_curved = True
    complexity = "usual"

    def unavailable(self, data):
        return "" if isinstance(data.robot, TurnsGravity) else "how gravity loads the axes is not known"

    def columns(self, data, shape):
        down, loads = data.robot.gravity_direction, data.once(_loads)
        return {
            Parameter(label): loads @ np.cross(axis, down)
            for label, axis in zip(("tilt_a", "tilt_b"), tilt_axes(down), strict=True)
        }

    def predict(self, data, parameters):
        turned = turned_gravity(data.robot, parameters)
        return data.once(_loads) @ (turned.gravity_direction - data.robot.gravity_direction)

    def mechanics(self, robot, parameters):
        return Mechanics(gravity_direction=turned_gravity(robot, parameters).gravity_direction)


def tilt_axes(down: np.ndarray) -> np.ndarray:
    """Two unit vectors perpendicular to gravity, in the base frame; down (3,) is a unit vector."""
    first = np.cross(down, np.eye(3)[np.argmin(np.abs(down))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(down, first)])


def turned_gravity(robot: TurnsGravity, parameters: dict[str, float]) -> Robot:
    """The robot on its tilted base."""
    axes = tilt_axes(robot.gravity_direction)
    vector = parameters["tilt_a"] * axes[0] + parameters["tilt_b"] * axes[1]
    return robot.with_gravity(Rotation.from_rotvec(vector).apply(robot.gravity_direction))


def _loads(data) -> np.ndarray:
    """Efforts (n, k, 3) of gravity along each axis of the base frame: its part of the efforts is linear in it."""
    either = [
        [data.robot.with_gravity(sign * axis).forces(data.q) for sign in (1.0, -1.0)]  # springs are the same in both
        for axis in np.eye(3)
    ]
    return np.stack([(up - down) / 2 for up, down in either], axis=-1)
