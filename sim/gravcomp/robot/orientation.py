"""Orientations that a user gives, in degrees, as positions of the axes, where the robot takes them."""

import csv
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.machine import Machine
from gravcomp.robot.protocol import PoseError, TakesOrientations


def positions_at(machine: Machine, angles_deg: np.ndarray, where: str) -> np.ndarray:
    """Positions (..., n), m or rad, at angles (..., k). where: of what was given, for messages.

    Raises InputError for a robot that takes no orientations, another number of angles, and one outside the workspace.
    """
    robot, angles = machine.robot, np.asarray(angles_deg, dtype=float)
    if not isinstance(robot, TakesOrientations):
        raise InputError(f"{where}: {machine.name} takes no orientations; give positions of its axes")
    if angles.shape[-1] != len(robot.orientation_names) or not np.isfinite(angles).all():
        raise InputError(f"{where}: need {', '.join(robot.orientation_names)}, a number of degrees each")
    try:
        return robot.at_orientation(np.deg2rad(angles))
    except PoseError as error:
        raise InputError(f"{where}: {error}") from None


def read_orientations(path: Path, machine: Machine) -> np.ndarray:
    """Angles (m, k), deg, of a CSV whose header is the robot's names with _deg. Raises InputError naming file and
    row."""
    if not isinstance(machine.robot, TakesOrientations):
        raise InputError(f"{path}: {machine.name} takes no orientations; leave --orientations out")
    header = [f"{name}_deg" for name in machine.robot.orientation_names]
    try:
        rows = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines(), strict=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a CSV of {','.join(header)}") from None
    rows = [[cell.strip() for cell in row] for row in rows if row and not row[0].lstrip().startswith("#")]
    if not rows or rows[0] != header:
        raise InputError(f"{path}: its header is {','.join(rows[0]) if rows else 'missing'}; give {','.join(header)}")
    angles = np.array([_row(path, number, row, len(header)) for number, row in enumerate(rows[1:], 1)])
    if len(angles):
        positions_at(machine, angles, str(path))
    return angles.reshape(-1, len(header))


def _row(path: Path, number: int, row: list[str], size: int) -> list[float]:
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        values = []
    if len(values) != size or not np.isfinite(values).all():
        raise InputError(f"{path}: row {number}: need {size} finite numbers")
    return values
