"""Friction over speed and cogging over position of one axis, as tables to be read linearly between two nodes.

Every effort is what the drive has to add to hold or move the axis, N or Nm, positive along +q: friction is positive at
positive speeds. Nodes are those of the compensator (``gravcomp.core.compensator_tables``), so both say the same there.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.core.compensation import FRICTION, Compensation
from gravcomp.core.compensator_tables import N_POSITIONS, node_speeds
from gravcomp.errors import InputError
from gravcomp.robot.machine import Drive


@dataclass(frozen=True)
class FrictionTable:
    """Signed speeds (k,), rising, m/s or rad/s; effort (k,), N or Nm; mu (k,): further effort per absolute one of the
    model."""

    speed: np.ndarray
    effort: np.ndarray
    mu: np.ndarray


@dataclass(frozen=True)
class CoggingTable:
    """Positions (k,) over one pitch, from 0 on, m or rad; effort (k,), N or Nm."""

    pitch: float
    position: np.ndarray
    effort: np.ndarray


def has_friction(c: Compensation, axis: int) -> bool:
    return any(getattr(c, name)[axis] for name in FRICTION)


def has_speed_friction(c: Compensation, axis: int) -> bool:
    """Any that does not follow the load."""
    return any(getattr(c, name)[axis] for name in FRICTION if name != "mu")


def has_cogging(c: Compensation, axis: int) -> bool:
    return bool(c.amplitude[axis].any())


def top_speed(c: Compensation, axis: int, given: float | None) -> float:
    """Where a table of friction ends, m/s or rad/s: what was given, else v_max. Raises InputError without either."""
    top = given or c.v_max[axis]
    if top <= c.v_full[axis]:
        told = f"{top:g} is not above v_full = {c.v_full[axis]:g}" if top else "is missing, and there is no v_max"
        raise InputError(f"--speed: of axis {axis + 1} {told}; give the largest speed of every axis")
    return float(top)


def friction_table(c: Compensation, drive: Drive, axis: int, top: float) -> FrictionTable:
    """Friction at the compensator's own speeds from half of v_dead up to top, in both directions, and 0 at rest."""
    speeds = node_speeds(drive)[:, axis][::-1]
    speeds = np.append(speeds[(speeds >= c.v_dead[axis] / 2) & (speeds < top)], top)
    signed = np.concatenate([-speeds[::-1], [0.0], speeds])
    columns = np.zeros((len(signed), c.n_axes))
    columns[:, axis] = signed
    return FrictionTable(signed, c.friction(columns)[:, axis], (np.sign(columns) * c.ramp(columns) * c.mu)[:, axis])


def cogging_table(c: Compensation, axis: int) -> CoggingTable:
    """Cogging at the compensator's nodes, and at the end of the pitch once more."""
    turns = np.arange(N_POSITIONS + 1) / N_POSITIONS
    effort = c.cogging(np.repeat(turns[:, None], c.n_axes, axis=1))[:, axis]
    return CoggingTable(float(c.pitch[axis]), turns * c.pitch[axis], effort)
