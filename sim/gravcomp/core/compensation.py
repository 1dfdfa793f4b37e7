"""Constants of the compensator: what the machine adds to the statics, by axis, and their file compensation.csv.

A row is ``axis,name,value``; axis is 1, 2, 3 ... or ``all``; what isn't named is zero; ``#`` starts a comment line.
Without the file every constant is zero and the compensator is transparent. Efforts are N and speeds m/s for an axis in
m, Nm and rad/s for one in rad:

    fc_pos, fc_neg   Coulomb friction when moving up and down, effort
    stribeck, vs     what static friction adds, and the speed at which it fades: stribeck exp(-(v/vs)^2)
    b_pos, b_neg     viscous friction likewise, effort per speed
    mu               load-dependent friction: mu |f|, f the network's effort; without unit, |mu| < 1
    v_dead, v_full   friction is 0 up to v_dead, whole from v_full on, linear in between; any friction needs both
    v_max            speed above which friction is that of v_max; 0 is no limit
    pitch            of the position table (cogging), m or rad
    a<h>, p<h>_rad   amplitude, effort, and phase of its harmonic h: a sin(2 pi h q / pitch + p), h = 1 .. 32

Names with the units of a linear axis at their end (fc_pos_n, v_dead_mps, a1_n ...) are read, too.
"""

import csv
import math
import re
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.files import write_atomically

COMPENSATION_CSV = "compensation.csv"
MAX_HARMONIC = 32  # of a table of 256 nodes: 8 nodes per wave
_HEADER = ["axis", "name", "value"]
_POSITIVE = ("vs", "v_dead", "v_full", "v_max", "pitch")
_HARMONICS = {"a": "amplitude", "p": "phase_rad"}  # array of a harmonic's constant
_WITH_UNIT = re.compile(
    r"(fc_pos|fc_neg|stribeck|a\d+)_n|(b_pos|b_neg)_ns_per_m|(vs|v_dead|v_full|v_max)_mps|(pitch)_m"
)
FRICTION = ("fc_pos", "fc_neg", "stribeck", "b_pos", "b_neg", "mu")


@dataclass(frozen=True)
class Compensation:
    """The constants of n axes, (n,) each, as named above; amplitude, phase_rad (n, MAX_HARMONIC), harmonic 1 first."""

    fc_pos: np.ndarray
    fc_neg: np.ndarray
    stribeck: np.ndarray
    vs: np.ndarray
    b_pos: np.ndarray
    b_neg: np.ndarray
    mu: np.ndarray
    v_dead: np.ndarray
    v_full: np.ndarray
    v_max: np.ndarray
    pitch: np.ndarray
    amplitude: np.ndarray
    phase_rad: np.ndarray

    @property
    def n_axes(self) -> int:
        return len(self.mu)

    @property
    def is_empty(self) -> bool:
        """Whether every constant is zero."""
        return not any(getattr(self, f.name).any() for f in fields(self))

    def ramp(self, v: np.ndarray) -> np.ndarray:
        """Part of the friction that acts at speeds v (..., n): 0 in the dead band, 1 from v_full on."""
        width = np.where(self.v_full > self.v_dead, self.v_full - self.v_dead, 1.0)
        return np.clip((np.abs(v) - self.v_dead) / width, 0.0, 1.0)

    def friction(self, v: np.ndarray) -> np.ndarray:
        """Friction (..., n), effort, without its load-dependent part, at signed speeds v (..., n)."""
        speed = np.abs(v)
        speed = np.where(self.v_max > 0, np.minimum(speed, self.v_max), speed)
        stribeck = self.stribeck * np.exp(-((speed / np.where(self.vs > 0, self.vs, 1.0)) ** 2))
        is_down = np.asarray(v) < 0
        coulomb = np.where(is_down, self.fc_neg, self.fc_pos)
        viscous = np.where(is_down, self.b_neg, self.b_pos) * speed
        return np.sign(v) * self.ramp(v) * (coulomb + stribeck + viscous)

    def cogging(self, turns: np.ndarray) -> np.ndarray:
        """Position table (..., n), effort, at q / pitch (..., n)."""
        angle = 2 * np.pi * turns[..., None] * np.arange(1, MAX_HARMONIC + 1)
        return np.sum(self.amplitude * np.sin(angle + self.phase_rad), axis=-1)

    def corrections(self, q: np.ndarray, v: np.ndarray, f: np.ndarray) -> np.ndarray:
        """What the compensator adds to efforts f (..., n) at positions q and signed speeds v, in floating point."""
        turns = q / np.where(self.pitch > 0, self.pitch, 1.0)
        load = np.sign(v) * self.ramp(v) * self.mu * np.abs(f)
        return self.friction(v) + load + self.cogging(turns)


def no_compensation(n_axes: int) -> Compensation:
    """All constants zero."""
    shapes = dict.fromkeys(_HARMONICS.values(), (n_axes, MAX_HARMONIC))
    return Compensation(**{f.name: np.zeros(shapes.get(f.name, n_axes)) for f in fields(Compensation)})


def load_compensation(folder: Path | str, n_axes: int) -> Compensation:
    """Read compensation.csv of a weights folder; without the file, all zero.

    Raises InputError naming file, row and column for text that isn't such a table, an unknown axis or name, a value
    that isn't finite or is out of range, a constant given twice, or constants that need another one.
    """
    path = Path(folder) / COMPENSATION_CSV
    result, given = no_compensation(n_axes), {}
    for row, line in _read_lines(path):
        where = f"{path}: row {row}"
        axes, name, value = _read_entry(where, line, n_axes)
        array, index = _place(result, name)
        for axis in axes:
            if (axis, name) in given:
                raise InputError(
                    f"{where}, column name: {name} of axis {axis + 1} was given in row {given[axis, name]}"
                )
            given[axis, name] = row
            array[(axis, *index)] = value
    check_compensation(result, path)
    return result


def save_compensation(compensation: Compensation, folder: Path | str, comment: str = "") -> None:
    """Write what isn't zero to compensation.csv, with the lines of comment above. Raises InputError if it cannot."""
    rows = []
    for name in _names():
        array, index = _place(compensation, name)
        values = array[(slice(None), *index)]
        if values.any() and (values == values[0]).all():
            rows.append(("all", name, float(values[0])))
        elif values.any():
            rows += [(axis, name, float(value)) for axis, value in enumerate(values, start=1)]
    lines = [f"# {line}" for line in comment.splitlines()] + [",".join(_HEADER)]
    lines += [f"{axis},{name},{value!r}" for axis, name, value in rows]
    write_atomically(Path(folder) / COMPENSATION_CSV, "\n".join(lines) + "\n")


def check_compensation(c: Compensation, where: Path | str) -> None:
    """Raise InputError for a constant that lacks another one; where names the source."""
    for axis in range(c.n_axes):
        has_friction = any(getattr(c, name)[axis] for name in FRICTION)
        needs = [
            (has_friction, "v_dead", "friction needs a dead band, or it would chatter at rest"),
            (c.stribeck[axis] != 0, "vs", "stribeck needs the speed at which it fades"),
            (c.amplitude[axis].any(), "pitch", "harmonics need the pitch"),
        ]
        for is_needed, name, why in needs:
            if is_needed and getattr(c, name)[axis] == 0:
                raise InputError(f"{where}: axis {axis + 1}: {name} is missing: {why}; add it")
        if has_friction and not c.v_full[axis] > c.v_dead[axis]:
            raise InputError(f"{where}: axis {axis + 1}: v_full must be above v_dead; raise it")


def _names() -> list[str]:
    names = [f.name for f in fields(Compensation) if f.name not in _HARMONICS.values()]
    return names + [name for h in range(1, MAX_HARMONIC + 1) for name in (f"a{h}", f"p{h}_rad")]


def _place(compensation: Compensation, name: str) -> tuple[np.ndarray, tuple[int, ...]]:
    """Array of a constant, and its index behind the axis."""
    harmonic = re.fullmatch(r"(a|p)(\d+)(_rad)?", name)
    if harmonic is None:
        return getattr(compensation, name), ()
    return getattr(compensation, _HARMONICS[harmonic[1]]), (int(harmonic[2]) - 1,)


def _read_lines(path: Path) -> list[tuple[int, list[str]]]:
    """Numbered rows below the header, comment and empty lines left out."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        rows = list(csv.reader(text.splitlines(), strict=True))
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a CSV file ({error}); give comma separated text") from error
    rows = [[cell.strip() for cell in row] for row in rows if row and not row[0].lstrip().startswith("#")]
    if not rows or rows[0] != _HEADER:
        found = ",".join(rows[0]) if rows else "nothing"
        raise InputError(f"{path}: row 0 (header): found {found}; the header must be {','.join(_HEADER)}")
    return list(enumerate(rows[1:], start=1))


def _read_entry(where: str, line: list[str], n_axes: int) -> tuple[range, str, float]:
    if len(line) != len(_HEADER):
        raise InputError(f"{where}: {len(line)} columns instead of {len(_HEADER)}; give {','.join(_HEADER)}")
    axis, name, text = line
    numbers = [str(k) for k in range(1, n_axes + 1)]
    if axis not in ("all", *numbers):
        raise InputError(f"{where}, column axis: {axis!r} is not an axis; give all, {', '.join(numbers)}")
    if with_unit := _WITH_UNIT.fullmatch(name):
        name = with_unit[with_unit.lastindex]
    if name == "clock_hz":
        raise InputError(f"{where}, column name: clock_hz stands in robot.toml; delete this row")
    if name not in _names():
        raise InputError(f"{where}, column name: {name!r} is not known; give one of {', '.join(_names()[:16])} ...")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}, column value: {text!r} is not a finite number; give one")
    if (name in _POSITIVE and value < 0) or (name == "mu" and abs(value) >= 1):
        limit = "must not be negative" if name in _POSITIVE else "must be in -1 .. 1"
        raise InputError(f"{where}, column value: {name} = {text} {limit}; correct it")
    return range(n_axes) if axis == "all" else range(int(axis) - 1, int(axis)), name, value
