"""A robot that is known by a CSV of poses and efforts from the user's own model: [model] kind = "table".

It gives training and test data. Between its rows nothing is known: other poses are refused, not interpolated.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from gravcomp.errors import InputError
from gravcomp.robot.fields import only, text
from gravcomp.robot.poses import read_samples
from gravcomp.robot.protocol import Bounds, PoseError
from gravcomp.robot.ranges import draw_rows

_SAME = 1e-9  # of the range of an axis
_MARGIN = 0.01  # of the range of efforts, for poses between the rows


@dataclass(frozen=True, eq=False)
class EffortTable:
    """Rows of positions q (N, n), m or rad as units say, and efforts f (N, n), N or N m. files: content by name."""

    position_units: tuple[str, ...]
    q: np.ndarray
    f: np.ndarray
    name: str
    files: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def n_axes(self) -> int:
        return len(self.position_units)

    @property
    def rows(self) -> np.ndarray:
        return self.q

    def forces(self, q: np.ndarray) -> np.ndarray:
        """Efforts (..., n) at rows q (..., n) of the table. Raises PoseError for any other pose."""
        q = np.asarray(q, dtype=float)
        if q.shape[-1:] != (self.n_axes,):
            raise PoseError(f"joint positions have shape {q.shape}; give (..., {self.n_axes})")
        wanted = q.reshape(-1, self.n_axes) / self._span
        finite = np.isfinite(wanted).all(axis=1)
        distance, row = self._rows.query(np.where(finite[:, None], wanted, 0.0))
        for k in np.flatnonzero(~finite | ~(distance <= _SAME)):
            place = ", ".join(f"{value:.6g}" for value in q.reshape(-1, self.n_axes)[k])
            raise PoseError(
                f"pose {k + 1}: ({place}) is no row of {self.name}, and between its rows nothing is known; add the "
                "pose, or give a model of another kind",
                int(k),
            )
        return self.f[row].reshape(q.shape)

    def workspace(self, n_poses: int, seed: int) -> np.ndarray:
        """Rows (n_poses, n) in random order, again from the start when there are fewer."""
        return self.q[draw_rows(len(self.q), n_poses, seed)]

    @cached_property
    def bounds(self) -> Bounds:
        low, high = self.q.min(axis=0), self.q.max(axis=0)
        least, most = self.f.min(axis=0), self.f.max(axis=0)
        spare = _MARGIN * (most - least)
        return Bounds(low, high, low, high, least - spare, most + spare)

    @cached_property
    def _span(self) -> np.ndarray:
        return np.ptp(self.q, axis=0)

    @cached_property
    def _rows(self) -> KDTree:
        return KDTree(self.q / self._span)


def from_table(table: dict, where: str) -> EffortTable:
    """The robot of a robot.toml at the path where. Raises InputError naming file, row and column."""
    only(table["model"], f"{where}: [model]", ("kind", "file"))
    path = Path(where).parent / text(table["model"], f"{where}: [model]", "file")
    return read_table(path)


def read_table(path: Path) -> EffortTable:
    """The robot of a CSV. Raises InputError naming file, row and column."""
    units, q, f = read_samples(path)
    for axis in np.flatnonzero(np.ptp(q, axis=0) == 0):
        raise InputError(f"{path}: axis {axis + 1} stands still in all rows; give poses over its working range")
    return EffortTable(units, q, f, path.name, {path.name: path.read_bytes()})
