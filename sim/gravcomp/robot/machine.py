"""The machine: robot.toml of a weights folder. What is to be held, and how the core meets it.

``[model]`` says where the statics come from, ``[[axis]]`` what an encoder's count and an ampere are, ``clock_hz`` how
fast the core runs, ``[network] activation`` what the network was trained with, ``form`` how the core computes
it. docs/guide/machine.md describes it.
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
from gravcomp.network.inputs import INPUTS, POSITION, SIN_COS
from gravcomp.robot.fields import entry, finite, only, positive, ratio
from gravcomp.robot.fields import text as text_of
from gravcomp.robot.kinds import robot_from_table
from gravcomp.robot.protocol import HasRanges, ReadsFiles, Robot

ROBOT_TOML = "robot.toml"
MAX_AXES = 8
# What the hardware computes; any other activation needs `gravcomp train --from`.
HARDWARE_ACTIVATION = "gamma"
ACTIVATIONS = (HARDWARE_ACTIVATION, "tanh")
PAPER, LEAN, SERIAL = FORMS = ("paper", "lean", "serial")
EFFORT_UNITS = {"m": "N", "rad": "Nm"}
COUNTS = {"m": "counts_per_m", "rad": "counts_per_turn"}  # key of [[axis]] by the axis' unit
_ALL_COUNTS = 2**32  # that a counter takes
# Keys of robot.toml that statics and workspace depend on: a network is trained on them.
_TRAINED_ON = ("model", "workspace", "effects", "empirical")
_CYCLE = 4  # counts of one cycle of an encoder, whose marks repeat with it
_KEYS = ("name", "clock_hz", "network", "axis", *_TRAINED_ON)
_AXIS_KEYS = ("name", "joint", *COUNTS.values(), "effort_per_ampere", "index_period", "low", "high", "input")


@dataclass(frozen=True)
class Axis:
    """One axis: unit m or rad, counts per unit, N/A or Nm/A, counts between index marks (0: one), working range, and
    which of INPUTS the network sees."""

    name: str
    unit: str
    counts_per_unit: float
    effort_per_ampere: float
    index_period: int
    low: float
    high: float
    input: str = POSITION


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
    form: str
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
    def inputs(self) -> tuple[str, ...]:
        """What the network sees of each axis."""
        return tuple(axis.input for axis in self.axes)

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

    @property
    def files(self) -> Mapping[str, bytes]:
        """What robot.toml refers to, content by name beside it."""
        return self.robot.files if isinstance(self.robot, ReadsFiles) else {}

    def contents(self, path: Path) -> dict[Path, str | bytes]:
        """What to write so that path is this robot.toml, or a model.toml with it: itself, and its files beside it."""
        return {path: self.text, **{path.parent / name: content for name, content in self.files.items()}}

    def trained_on(self) -> dict:
        """What a network of this machine is trained on, value by key: statics with their files, workspace, ranges and
        joints, inputs, activation."""
        table = self.table
        facts = {key: table[key] for key in _TRAINED_ON if key in table}
        files = {f"{name} sha256": hashlib.sha256(content).hexdigest() for name, content in self.files.items()}
        axes = {f"axis {k}": self._trained_axis(k) for k in range(1, self.n_axes + 1)}
        return dict(_flat({**facts, **files, "network": {"activation": self.activation}, **axes}))

    def _trained_axis(self, number: int) -> dict:
        axis, given = self.axes[number - 1], self.table["axis"][number - 1]
        facts = {"low": axis.low, "high": axis.high}
        if "joint" in given:
            facts["joint"] = given["joint"]
        return facts if axis.input == POSITION else facts | {"input": axis.input}

    def turns_to_wrap(self) -> dict[str, float]:
        """By name of axes that turn without limits, turns either way after which their count wraps amid a turn.

        The phase of such an axis jumps there: not where all counts are whole turns, as with a power of two a turn.
        """
        turns = {}
        for axis, given in zip(self.axes, self.table["axis"], strict=True):
            if axis.input != SIN_COS or {"low", "high"} & given.keys():
                continue
            if _ALL_COUNTS % Fraction(given[COUNTS[axis.unit]]):
                turns[axis.name] = _ALL_COUNTS / 2 / (2 * math.pi * axis.counts_per_unit)
        return turns

    def core_facts(self) -> str:
        """What the ROM holds of this machine, as text for its hash: clock, counts, efforts per ampere, activation,
        form."""
        axes = [[a.unit, a.counts_per_unit, a.effort_per_ampere, a.index_period, *_other_input(a)] for a in self.axes]
        other_form = [] if self.form == PAPER else [self.form]
        return json.dumps([self.clock_hz, self.activation, axes, *other_form])

    def with_activation(self, activation: str) -> "Machine":
        """The same machine, with a network of another activation."""
        pattern = r'^(\s*activation\s*=\s*)"[^"]*"'
        return replace(self, activation=activation, text=re.sub(pattern, rf'\1"{activation}"', self.text, flags=re.M))

    def with_form(self, form: str) -> "Machine":
        """The same machine, its network in another form."""
        without = re.sub(rf'^\s*form\s*=\s*"({"|".join(FORMS)})".*\n', "", self.text, flags=re.M)
        text = re.sub(r"^\s*\[network\].*\n", rf'\g<0>form = "{form}"\n', without, flags=re.M)
        return parse_machine(text, self.where)


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
    except (ValueError, RecursionError) as error:  # a whole number of thousands of digits, too
        raise InputError(f"{where}: not valid TOML ({error}); correct that line") from error
    only(table, where, _KEYS)
    clock_hz = positive(table, where, "clock_hz")
    if clock_hz != int(clock_hz) or clock_hz >= 2**31:
        raise InputError(f"{where}: clock_hz = {clock_hz:g} is not a whole number of Hz below 2^31; correct it")
    activation = entry(entry(table, where, "network"), f"{where}: [network]", "activation")
    if activation not in ACTIVATIONS:
        raise InputError(f"{where}: [network] activation = {activation!r}; give one of {', '.join(ACTIVATIONS)}")
    only(table["network"], f"{where}: [network]", ("activation", "form"))
    form = table["network"].get("form", PAPER)
    if form not in FORMS:
        raise InputError(f"{where}: [network] form = {form!r}; give one of {', '.join(FORMS)}")
    robot = robot_from_table(table, where)
    entries = entry(table, where, "axis")
    if not isinstance(entries, list) or not 1 <= len(entries) <= MAX_AXES:
        raise InputError(f"{where}: [[axis]]: give one table per axis, 1 to {MAX_AXES}")
    if len(entries) != robot.n_axes:
        raise InputError(f"{where}: {len(entries)} tables [[axis]], but the robot has {robot.n_axes} axes")
    axes = tuple(_axis(table, f"{where}: axis {k + 1}", robot, k) for k, table in enumerate(entries))
    name = text_of(table, where, "name") if "name" in table else Path(where).parent.name
    return Machine(name, clock_hz, activation, form, robot, axes, text, where)


def _other_input(axis: Axis) -> list[str]:
    return [] if axis.input == POSITION else [axis.input]


def trained_on_hash(facts: Mapping) -> str:
    """SHA-256 of ``Machine.trained_on``."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def _axis(table, where: str, robot: Robot, index: int) -> Axis:
    if not isinstance(table, dict):
        raise InputError(f"{where} is not a table; write [[axis]]")
    only(table, where, _AXIS_KEYS)
    unit = robot.position_units[index]
    kind = table.get("input", POSITION)
    if kind not in INPUTS or (kind == SIN_COS and unit != "rad"):
        mend = "give position or sin_cos" if unit == "rad" else "this core takes positions alone of a linear axis"
        raise InputError(f"{where}: input = {kind!r}; {mend}")
    period = table.get("index_period", 0)
    is_whole = isinstance(period, int) and not isinstance(period, bool)
    if not is_whole or not 0 <= period < _ALL_COUNTS or period % _CYCLE:
        raise InputError(f"{where}: index_period = {period!r} is no multiple of {_CYCLE} counts below 2^32; correct "
                         "it, 0 for one mark")  # fmt: skip
    low, high = _range(table, where, robot, index)
    return Axis(
        name=str(table.get("name", table.get("joint", f"axis {index + 1}"))),
        unit=unit,
        counts_per_unit=_counts_per_unit(table, where, unit),
        effort_per_ampere=positive(table, where, "effort_per_ampere"),
        index_period=period,
        low=low,
        high=high,
        input=kind,
    )


def _counts_per_unit(table: Mapping, where: str, unit: str) -> float:
    """Counts per m or rad."""
    key = COUNTS[unit]
    (other,) = set(COUNTS.values()) - {key}
    if key not in table:
        clash = f", {other} is of other axes" if other in table else ""
        raise InputError(f"{where}: {key} is missing; the axis moves in {unit}{clash}")
    if other in table:
        raise InputError(f"{where}: {other} is of other axes; the axis moves in {unit}, take it out")
    return positive(table, where, key) if unit == "m" else ratio(table[key], f"{where}: {key}") / (2 * math.pi)


def _range(table: Mapping, where: str, robot: Robot, index: int) -> tuple[float, float]:
    """Working range of an axis: what robot.toml gives, else what the robot says."""
    ends = {key: finite(table, where, key) for key in ("low", "high") if key in table}
    if len(ends) < 2:
        known = robot.ranges if isinstance(robot, HasRanges) else (robot.bounds.q_low, robot.bounds.q_high)
        ends = {"low": float(known[0][index]), "high": float(known[1][index])} | ends
    if ends["low"] >= ends["high"]:
        raise InputError(f"{where}: low = {ends['low']:g} is not below high = {ends['high']:g}; correct them")
    return ends["low"], ends["high"]


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
