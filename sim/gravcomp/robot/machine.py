"""The machine: robot.toml of a weights folder. What is to be held, and how the core meets it.

``[model]`` says where the statics come from, ``[[axis]]`` what an encoder's count and an ampere are, ``clock_hz`` how
fast the core runs, ``[network] activation`` what the network was trained with. docs/guide/machine.md describes it.
"""

import hashlib
import json
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.kinds import robot_from_table
from gravcomp.robot.protocol import Robot

ROBOT_TOML = "robot.toml"
MAX_AXES = 8
# What the hardware computes; any other activation needs `gravcomp train --from`.
HARDWARE_ACTIVATION = "gamma"
ACTIVATIONS = (HARDWARE_ACTIVATION, "tanh")
EFFORT_UNITS = {"m": "N", "rad": "Nm"}
# Keys of robot.toml that statics and workspace depend on: a network is trained on them.
_TRAINED_ON = ("model", "workspace", "effects", "empirical")


@dataclass(frozen=True)
class Axis:
    """One axis: unit m or rad, counts per unit, N/A or Nm/A, counts between index marks (0: one), working range."""

    name: str
    unit: str
    counts_per_unit: float
    effort_per_ampere: float
    index_period: int
    low: float
    high: float


@dataclass(frozen=True)
class Drive:
    """How the core meets the axes: counts per m or rad (n,), N/A or Nm/A (n,), Hz of its clock."""

    counts_per_unit: np.ndarray
    effort_per_ampere: np.ndarray
    clock_hz: float

    @property
    def unit_per_count(self) -> np.ndarray:
        """m or rad (n,)."""
        return 1.0 / self.counts_per_unit

    def counts(self, q: np.ndarray) -> np.ndarray:
        """Encoder counts (..., n), whole ones, at positions q (..., n), m or rad."""
        return np.rint(q / self.unit_per_count).astype(np.int64)

    def positions(self, counts: np.ndarray) -> np.ndarray:
        """Positions (..., n), m or rad, at encoder counts (..., n)."""
        return counts * self.unit_per_count


@dataclass(frozen=True)
class Machine:
    """robot.toml as read. text: the file itself; where: its name, for messages."""

    name: str
    clock_hz: float
    activation: str
    robot: Robot
    axes: tuple[Axis, ...]
    text: str
    where: str

    @property
    def n_axes(self) -> int:
        return len(self.axes)

    @property
    def position_units(self) -> tuple[str, ...]:
        return tuple(axis.unit for axis in self.axes)

    @property
    def effort_unit(self) -> str:
        """N or Nm, or both where the axes differ."""
        return " or ".join(sorted({EFFORT_UNITS[unit] for unit in self.position_units}))

    @cached_property
    def drive(self) -> Drive:
        per_unit, per_ampere = zip(*((axis.counts_per_unit, axis.effort_per_ampere) for axis in self.axes), strict=True)
        return Drive(np.array(per_unit), np.array(per_ampere), self.clock_hz)

    @property
    def table(self) -> dict:
        return tomllib.loads(self.text)

    def trained_on(self) -> dict:
        """What a network of this machine is trained on, value by key: statics, workspace, ranges, activation."""
        table = self.table
        facts = {key: table[key] for key in _TRAINED_ON if key in table}
        ranges = {f"axis {k}": {"low": axis.low, "high": axis.high} for k, axis in enumerate(self.axes, start=1)}
        return dict(_flat({**facts, "network": {"activation": self.activation}, **ranges}))

    def core_facts(self) -> str:
        """What the ROM holds of this machine, as text for its hash: clock, counts, efforts per ampere, activation."""
        axes = [[a.unit, a.counts_per_unit, a.effort_per_ampere, a.index_period] for a in self.axes]
        return json.dumps([self.clock_hz, self.activation, axes])

    def with_activation(self, activation: str) -> "Machine":
        """The same machine, with a network of another activation."""
        pattern = r'^(\s*activation\s*=\s*)"[^"]*"'
        return replace(self, activation=activation, text=re.sub(pattern, rf'\1"{activation}"', self.text, flags=re.M))


def load_machine(folder: Path | str) -> Machine:
    """Read robot.toml of a machine folder. Raises InputError naming file, table and key."""
    folder = Path(folder)
    if not (folder / ROBOT_TOML).is_file():
        raise InputError(f"{folder}: no {ROBOT_TOML}; a machine folder needs it, see docs/guide/machine.md")
    return read_machine(folder / ROBOT_TOML)


def read_machine(path: Path | str) -> Machine:
    """Read the file itself. Raises InputError naming file, table and key."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a {ROBOT_TOML}") from error
    return parse_machine(text, str(path))


def parse_machine(text: str, where: str) -> Machine:
    """The machine of a robot.toml's text; where names it in messages. Raises InputError."""
    try:
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{where}: not valid TOML ({error}); correct that line") from error
    clock_hz = _positive(table, where, "clock_hz")
    if clock_hz != int(clock_hz) or clock_hz >= 2**31:
        raise InputError(f"{where}: clock_hz = {clock_hz:g} is not a whole number of Hz below 2^31; correct it")
    activation = _entry(_entry(table, where, "network"), f"{where}: [network]", "activation")
    if activation not in ACTIVATIONS:
        raise InputError(f"{where}: [network] activation = {activation!r}; give one of {', '.join(ACTIVATIONS)}")
    robot = robot_from_table(table, where)
    entries = _entry(table, where, "axis")
    if not isinstance(entries, list) or not 1 <= len(entries) <= MAX_AXES:
        raise InputError(f"{where}: [[axis]]: give one table per axis, 1 to {MAX_AXES}")
    if len(entries) != robot.n_axes:
        raise InputError(f"{where}: {len(entries)} tables [[axis]], but the robot has {robot.n_axes} axes")
    axes = tuple(_axis(entry, f"{where}: axis {k + 1}", robot, k) for k, entry in enumerate(entries))
    name = table.get("name", Path(where).parent.name)
    return Machine(str(name), clock_hz, activation, robot, axes, text, where)


def trained_on_hash(facts: Mapping) -> str:
    """SHA-256 of ``Machine.trained_on``."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def _axis(entry, where: str, robot: Robot, index: int) -> Axis:
    if not isinstance(entry, dict):
        raise InputError(f"{where} is not a table; write [[axis]]")
    known = {"name", "joint", "counts_per_m", "counts_per_turn", "effort_per_ampere", "index_period", "low", "high"}
    for key in entry.keys() - known - {"input"}:
        raise InputError(f"{where}: {key} is not known; give {', '.join(sorted(known))}")
    if entry.get("input", "position") != "position":
        raise InputError(f"{where}: input = {entry['input']!r}; this core takes positions alone")
    unit = robot.position_units[index]
    key = "counts_per_m" if unit == "m" else "counts_per_turn"
    if key not in entry:
        raise InputError(f"{where}: {key} is missing; the axis moves in {unit}")
    counts = _ratio(entry[key], f"{where}: {key}") if unit == "rad" else _positive(entry, where, key)
    period = entry.get("index_period", 0)
    if isinstance(period, bool) or not isinstance(period, int) or period < 0:
        raise InputError(f"{where}: index_period = {period!r} is not a number of counts; give 0 for one mark")
    low = _finite(entry, where, "low") if "low" in entry else float(robot.bounds.q_low[index])
    high = _finite(entry, where, "high") if "high" in entry else float(robot.bounds.q_high[index])
    if low >= high:
        raise InputError(f"{where}: low = {low:g} is not below high = {high:g}; correct them")
    return Axis(
        name=str(entry.get("name", entry.get("joint", f"axis {index + 1}"))),
        unit=unit,
        counts_per_unit=counts if unit == "m" else counts / (2 * math.pi),
        effort_per_ampere=_positive(entry, where, "effort_per_ampere"),
        index_period=period,
        low=low,
        high=high,
    )


def _entry(table: Mapping, where: str, key: str):
    if not isinstance(table, Mapping) or key not in table:
        raise InputError(f"{where}: {key} is missing; add it")
    return table[key]


def _finite(table: Mapping, where: str, key: str) -> float:
    value = _entry(table, where, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e300:
        raise InputError(f"{where}: {key} = {value!r} is not a finite number; give one")
    return float(value)


def _positive(table: Mapping, where: str, key: str) -> float:
    value = _finite(table, where, key)
    if value <= 0:
        raise InputError(f"{where}: {key} = {value!r} is out of range; give a positive number")
    return value


def _ratio(value, where: str) -> float:
    """A whole number or "a/b": the phase of a joint that turns for ever must not drift."""
    try:
        if isinstance(value, bool) or not isinstance(value, (int, str)):
            raise ValueError
        ratio = Fraction(value)
    except (ValueError, ZeroDivisionError):
        raise InputError(f'{where} = {value!r} is not a whole number or a ratio "a/b"; give one') from None
    if ratio <= 0:
        raise InputError(f"{where} = {value!r} is out of range; give a positive number")
    return float(ratio)


def _flat(value, key: str = ""):
    """(key, value) of the leaves of nested tables."""
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from _flat(item, f"{key}.{name}" if key else name)
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for number, item in enumerate(value, start=1):
            yield from _flat(item, f"{key} {number}")
    else:
        is_number = isinstance(value, int) and not isinstance(value, bool)
        yield key, float(value) if is_number else value
