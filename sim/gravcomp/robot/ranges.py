"""What [[axis]] and [workspace] of robot.toml say about where a robot of a file works."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.fields import entry, finite, only, text
from gravcomp.robot.poses import read_positions

_WORKSPACE_KEYS = {"box": ("kind",), "poses": ("kind", "file")}
_BEYOND = 1e-3  # of a joint's range: its limits are often rounded


@dataclass(frozen=True)
class Range:
    """Working range low .. high of an axis, m or rad."""

    low: float
    high: float


@dataclass(frozen=True)
class Limits:
    """What a file says of a joint: unit m or rad, and its range or None where it moves without limit."""

    unit: str
    range: Range | None


def axis_entries(table: Mapping, where: str) -> list[Mapping]:
    """The tables [[axis]]. Raises InputError."""
    entries = entry(table, where, "axis")
    if not isinstance(entries, list) or not entries or not all(isinstance(one, Mapping) for one in entries):
        raise InputError(f"{where}: [[axis]]: give one table per axis")
    return entries


def working_range(axis: Mapping, where: str, limits: Limits) -> Range:
    """low and high of [[axis]], by default the joint's limits, or a turn if its input is sin_cos. Raises InputError."""
    name = axis.get("joint", "it")
    endless = Range(-math.pi, math.pi) if limits.unit == "rad" and axis.get("input") == "sin_cos" else None
    default = limits.range or endless
    if default is None and not {"low", "high"} <= axis.keys():
        mend = 'give low and high, or input = "sin_cos"' if limits.unit == "rad" else "give low and high"
        raise InputError(f"{where}: {name!r} moves without limit; {mend}")
    low, high = (finite(axis, where, key) if key in axis else getattr(default, key) for key in ("low", "high"))
    if low >= high:
        raise InputError(f"{where}: low = {low:g} is not below high = {high:g}; correct them")
    if limits.range:
        spare = _BEYOND * (limits.range.high - limits.range.low)
        if low < limits.range.low - spare or high > limits.range.high + spare:
            raise InputError(
                f"{where}: low .. high = {low:g} .. {high:g} is beyond the limits of {name!r}, {limits.range.low:g} .. "
                f"{limits.range.high:g} {limits.unit}; correct them"
            )
    return Range(low, high)


class Box:
    """[workspace] kind = "box": every axis anywhere in its range, independent of the others."""

    def __init__(self, ranges: list[Range]):
        self.low = np.array([one.low for one in ranges])
        self.high = np.array([one.high for one in ranges])

    def sample(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, n), uniform."""
        return np.random.default_rng(seed).uniform(self.low, self.high, (n_poses, len(self.low)))

    def boundary(self, n_poses: int, seed: int) -> np.ndarray:
        """Positions (n_poses, n), uniform over the faces' own coordinates, each face as often as any other."""
        rng, q = np.random.default_rng(seed), self.sample(n_poses, seed)
        rows, axis = np.arange(n_poses), rng.integers(len(self.low), size=n_poses)
        q[rows, axis] = np.where(rng.random(n_poses) < 0.5, self.low[axis], self.high[axis])
        return q


class Poses:
    """[workspace] kind = "poses": rows of a CSV."""

    def __init__(self, q: np.ndarray):
        self.q, self.low, self.high = q, q.min(axis=0), q.max(axis=0)

    def sample(self, n_poses: int, seed: int) -> np.ndarray:
        """Rows (n_poses, n) in random order, again from the start when there are fewer."""
        return self.q[draw_rows(len(self.q), n_poses, seed)]

    boundary = sample  # a list of poses is all that there is


def draw_rows(n_rows: int, n_wanted: int, seed: int) -> np.ndarray:
    """Numbers of rows in random order; all of them before any comes again."""
    rng = np.random.default_rng(seed)
    rounds = -(-n_wanted // n_rows)
    return np.concatenate([rng.permutation(n_rows) for _ in range(rounds)])[:n_wanted]


def workspace_of(table: Mapping, where: str, ranges: list[Range], units: tuple[str, ...]) -> Box | Poses:
    """The workspace of robot.toml: a box unless [workspace] says poses. Raises InputError."""
    section = table.get("workspace", {"kind": "box"})
    place = f"{where}: [workspace]"
    kind = text(section, place, "kind")
    if kind in _WORKSPACE_KEYS:
        only(section, place, _WORKSPACE_KEYS[kind])
    if kind == "box":
        return Box(ranges)
    if kind != "poses":
        raise InputError(f'{place} kind = {kind!r}; give "box" or "poses"')
    return Poses(read_positions(Path(where).parent / text(section, place, "file"), units))


def workspace_files(table: Mapping, where: str) -> dict[str, bytes]:
    """The CSV of [workspace], if any, content by name."""
    section = table.get("workspace", {})
    if section.get("kind") != "poses":
        return {}
    return {section["file"]: (Path(where).parent / section["file"]).read_bytes()}
