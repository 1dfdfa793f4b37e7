"""The base stands askew: gravity points elsewhere in its frame. A turn about gravity itself cannot be seen."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.statics import holding_forces_at


class BaseTilt(Effect):
    """f_model with gravity turned by a small rotation tilt_a, tilt_b, rad, about two axes perpendicular to it."""

    name = "base_tilt"
    driver = "q"
    equation = "f_model with gravity turned by a small rotation, less f_model"
    hardware = "network"
    units = {"tilt": "rad"}  # noqa: RUF012
    per_axis = False
    complexity = 0.5

    def unavailable(self, data):
        return "" if data.robot is not None else "how gravity loads the axes is not known"

    def columns(self, data, shape):
        down = data.robot.gravity_direction
        return {
            Parameter(label): holding_forces_at(data.q, replace(data.robot, gravity_direction=np.cross(axis, down)))
            for label, axis in zip(("tilt_a", "tilt_b"), tilt_axes(down), strict=True)
        }

    def predict(self, data, parameters):
        turned = turned_gravity(data.robot, parameters)
        return holding_forces_at(data.q, turned) - holding_forces_at(data.q, data.robot)


def tilt_axes(down: np.ndarray) -> np.ndarray:
    """Two unit vectors perpendicular to gravity, in the base frame; down (3,) is a unit vector."""
    first = np.cross(down, np.eye(3)[np.argmin(np.abs(down))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(down, first)])


def turned_gravity(robot: RobotParameters, parameters: dict[str, float]) -> RobotParameters:
    """The robot on its tilted base."""
    axes = tilt_axes(robot.gravity_direction)
    vector = parameters["tilt_a"] * axes[0] + parameters["tilt_b"] * axes[1]
    return replace(robot, gravity_direction=Rotation.from_rotvec(vector).apply(robot.gravity_direction))
