"""What is of ordinary size on a machine, in units of the Sphe.I.Ro.: there the ranges of imperfections are stated."""

from dataclasses import dataclass

import numpy as np

from gravcomp.prototype.engine import Engine
from gravcomp.robot.machine import Machine
from gravcomp.robot.mechanism.robot import Mechanism
from gravcomp.robot.protocol import HasPassiveJoints

# Of the Sphe.I.Ro.: RMS effort, reach of an axis to either side, mass, leg; RMS speed of its passive joints by unit,
# per speed of the axes.
_EFFORT_N, _REACH_M, _MASS_KG, _LEG_M = 52.6, 0.161, 48.0, 0.25
_PASSIVE_SPEED = {"m": 0.18, "rad": 2.3}
_LONGEST_TURN_RAD = 1.0  # a joint that turns farther works in a part of it
_LEAST_EFFORT = 0.3  # of the largest axis': one that bears no weight has friction all the same
_N_POSES, _SEED = 500, 3


@dataclass(frozen=True)
class Sizes:
    """effort (n,), position (n,): of each axis; mass, length: of a payload and where it hangs; passive: of friction in
    passive joints by unit, and how many of them there are."""

    effort: np.ndarray
    position: np.ndarray
    mass: float
    length: float
    passive: dict[str, float]
    n_passive: dict[str, int]

    @property
    def n_axes(self) -> int:
        return len(self.effort)

    def count(self, per: str) -> int:
        """Values of a parameter: per "axis", passive "m" or "rad", or "machine" (0: one number)."""
        return {"axis": self.n_axes, "machine": 0, **self.n_passive}[per]

    def of(self, per: str, effort: int, position: int, mass: int, length: int) -> np.ndarray | float:
        """Size of a quantity of these dimensions, by axis where it is per axis."""
        if per in self.passive:
            return self.passive[per] ** effort
        size = self.effort**effort * self.position**position * self.mass**mass * self.length**length
        return size if per == "axis" else float(np.exp(np.mean(np.log(size))))


SPHEIRO = Sizes(np.ones(3), np.ones(3), 1.0, 1.0, {"m": 1.0, "rad": 1.0}, {"m": 3, "rad": 3})


def reach_of(machine: Machine) -> np.ndarray:
    """How far each axis works to either side, (n,), m or rad."""
    half = np.array([(axis.high - axis.low) / 2 for axis in machine.axes])
    turns = np.array([unit == "rad" for unit in machine.position_units])
    return np.where(turns, np.minimum(half, _LONGEST_TURN_RAD), half)


def sizes_of(machine: Machine, engine: Engine) -> Sizes:
    """Sizes of a machine: from its statics over the workspace, and its masses."""
    robot = machine.robot
    if not isinstance(robot, Mechanism):
        return SPHEIRO
    q = robot.workspace(_N_POSES, _SEED)
    rms = np.sqrt(np.mean(robot.forces(q) ** 2, axis=0))
    effort = np.maximum(rms, _LEAST_EFFORT * rms.max()) / _EFFORT_N
    passive = {}
    if isinstance(robot, HasPassiveJoints):
        j, units = robot.passive_jacobian(q), np.array(robot.passive_units)
        for unit in dict.fromkeys(robot.passive_units):
            felt = np.sqrt(np.mean(j[:, units == unit] ** 2))  # by an axis, of a friction of one
            passive[unit] = float(np.mean(effort) * _PASSIVE_SPEED[unit] / felt)
    places = robot.tree.place(robot.configurations(q[:1]).qpos).origin[:, 0]
    return Sizes(
        effort=effort,
        position=reach_of(machine) / _REACH_M,
        mass=float(engine.model.body_mass.sum() / _MASS_KG),
        length=float(np.linalg.norm(places, axis=-1).max() / _LEG_M) or 1.0,
        passive=passive,
        n_passive={unit: len(engine.passive_dofs(unit)) for unit in ("m", "rad")},
    )
