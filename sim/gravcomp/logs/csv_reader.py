"""Reads the measured CSV: time, positions, velocities, efforts, temperature, predictions of the user's own model.

Columns: ``t_s``; per axis i ``q{i}_m`` or ``q{i}_rad``; optional ``v{i}_mps`` or ``v{i}_radps``; ``f{i}_n``,
``f{i}_nm`` or ``i{i}_a``; optional ``temp_c``; optional ``fm{i}_n``, ``fm{i}_nm`` or ``fm{i}_a``; other known units
are converted. # is a comment. What else a file may look like is in ``text_table`` and ``headers``.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from gravcomp.errors import InputError
from gravcomp.logs import clock
from gravcomp.logs.force_surface import fit_force_function
from gravcomp.logs.glitches import without_glitches
from gravcomp.logs.measurement import Measurement, velocity_from_position
from gravcomp.logs.missing import marks
from gravcomp.logs.text_table import TextTable, is_missing, read_text_table
from gravcomp.logs.thresholds import LARGEST
from gravcomp.logs.units import KNOWN, OF_THE_MACHINE, in_contract
from gravcomp.robot.machine import EFFORT_UNITS, Machine
from gravcomp.robot.protocol import PoseError, Robot

MIN_SAMPLES = 30
_OTHER_ROBOT = 0.5  # of the RMS of the predictions: a robot that holds something else by more is not theirs
_COLUMN = re.compile(r"^(q|v|f|i|fm)([1-9]\d*)_(m|rad|mps|radps|n|nm|a)$")
_SUFFIXES = {"q": ("m", "rad"), "v": ("mps", "radps"), "f": ("n", "nm"), "i": ("a",), "fm": ("n", "nm", "a")}
_VELOCITY_OF = {"m": "mps", "rad": "radps"}
# A name this close to a column's is one misspelt: it must not be left out unnoticed.
_MISSPELT = re.compile(r"^(?:(t|temp)|(q|v|f|i|fm)(\d+))_[a-z]+$", re.IGNORECASE)
_UNITS = {"n": "N", "nm": "Nm", "a": "A"}


def read_measurement(
    path: Path | str, machine: Machine | None = None, units: Mapping[str, tuple[str, float]] | None = None
) -> Measurement:
    """Read one CSV; without fm columns the machine's statics are the model.

    units: size of the machine's own units, as {"counts": ("m", 1e-6)}. What had to be put right stands in the notes.
    Raises InputError, one line naming file, row, column and what to do.
    """
    log, notes = _read_log(Path(path), units or {})
    for put_right in (_without_gaps, _without_marks, partial(_in_contract, units=units or {})):
        log, told = put_right(log)
        notes += told
    columns = _columns(log)
    t_s, run, told = _time(log)
    notes += told
    q, told = without_glitches(_stack(log, columns["q"]), run)
    notes += told
    force, nominal, by_axis = _effort(log, columns, machine)
    unit = ", ".join(dict.fromkeys(by_axis))
    v = _stack(log, columns["v"]) if columns["v"] else None
    if v is None:
        draft = Measurement(log.path.name, t_s, q, None, force, force, unit, (), run=run)
        v = velocity_from_position(t_s, q, run) if draft.is_ordered and np.ptp(t_s) > 0 else None
    is_predicted = nominal is not None
    if is_predicted:
        robot, told = _robot_behind(columns, machine, q, nominal, by_axis)
        notes += told
        force_at = fit_force_function(q, nominal, [_suffix(name) for name in columns["q"]])
        force_at = force_at or (robot.forces if robot else None)
    else:
        _check_machine(log, columns, machine)
        robot, nominal, force_at = machine.robot, _statics(log, q, machine), machine.robot.forces
    return Measurement(
        log.path.name, t_s, q, v, force, nominal, unit, tuple(_suffix(name) for name in columns["q"]),
        temp_c=log.table["temp_c"].to_numpy() if "temp_c" in log.table else None, force_at=force_at,
        robot=robot, run=run if run.any() else None, is_predicted=is_predicted,
        units=by_axis if len(set(by_axis)) > 1 else (), notes=tuple(notes), n_dropped=log.n_dropped,
    )  # fmt: skip


@dataclass(frozen=True)
class _Log:
    """The columns that the contract knows, in its units where they are known; rows of the file that are left."""

    path: Path
    table: pd.DataFrame
    rows: list[int]
    header_row: int
    originals: dict[str, str]
    without_unit: dict[str, str]
    n_dropped: int = 0

    @property
    def header(self) -> str:
        return f"{self.path}: row {self.header_row}"

    def only(self, kept: np.ndarray) -> "_Log":
        """The rows where kept (n,) is true; the others are counted."""
        rows = [row for row, keep in zip(self.rows, kept, strict=True) if keep]
        return replace(self, table=self.table[kept], rows=rows, n_dropped=self.n_dropped + int((~kept).sum()))


def _read_log(path: Path, units: Mapping) -> tuple[_Log, list[str]]:
    """Numbers of a file's cells, NaN where a cell has none, and what reading had to put right."""
    text = read_text_table(path)
    if len(text.cells) < MIN_SAMPLES:
        row = text.rows[-1] if text.rows else text.header_row
        raise InputError(f"{path}: row {row}, column {text.columns[0].name}: only {len(text.cells)} samples; "
                         f"give at least {MIN_SAMPLES}")  # fmt: skip
    by_column = {}
    for found, cells in zip(text.columns, zip(*text.cells, strict=True), strict=True):
        contract = (in_contract(found.name, units) or (found.name,))[0]
        is_known = _COLUMN.match(contract) is not None or contract in ("t_s", "temp_c")
        by_column[found.name] = _numbers(path, text, found.name, cells) if is_known else np.zeros(len(cells))
    without_unit = {found.should_be: found.original for found in text.columns if found.should_be}
    originals = {found.name: found.original for found in text.columns}
    return _Log(path, pd.DataFrame(by_column), text.rows, text.header_row, originals, without_unit), text.notes


def _numbers(path: Path, text: TextTable, name: str, cells: tuple[str, ...]) -> np.ndarray:
    """Values (n,) of a column, NaN where a cell has none. Raises InputError for a cell that is no number."""
    values = pd.to_numeric(pd.Series(cells), errors="coerce").to_numpy(dtype=float, copy=True)
    missing = np.isnan(values)  # no mark of a missing value is a number
    missing[missing] = [is_missing(cells[k]) for k in np.flatnonzero(missing)]
    bad = ~missing & ~(np.abs(values) < (1e20 if name.startswith("t_") else LARGEST))
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(f"{path}: row {text.rows[k]}, column {name}: {cells[k]!r} is not a finite number up to "
                         f"{LARGEST:g}; correct or delete that row")  # fmt: skip
    return values


def _without_gaps(log: _Log) -> tuple[_Log, list[str]]:
    """The rows that have a value in every column, and a line on the others; a column without any is none."""
    notes, table = [], log.table
    empty = [name for name in table if table[name].isna().all()]
    speeds = [name for name in table if _MISSPELT.match(name) and name.startswith("v")]
    for name in empty:
        if name != "temp_c" and not (name in speeds and {*speeds} <= {*empty}):
            raise InputError(f"{log.header}: column {name} has no value in any row; log it, or delete the column")
        notes.append(f"{name} has no value in any row: left aside")
    table = table.drop(columns=empty)
    if "temp_c" in table and table["temp_c"].isna().any():
        notes.append(f"temp_c: {table['temp_c'].isna().sum()} cells without a value are filled from their neighbours")
        table = table.assign(temp_c=table["temp_c"].interpolate(limit_direction="both"))
    gaps = table.isna()
    log = replace(log, table=table)
    if not gaps.to_numpy().any():
        return log, notes
    dropped = gaps.any(axis=1).to_numpy()
    where = ", ".join(f"{name} {count}" for name, count in gaps.sum().items() if count)
    notes.append(f"cells without a value ({where}): {dropped.sum()} rows are left out")
    if np.count_nonzero(~dropped) < MIN_SAMPLES:
        raise InputError(f"{log.header}: {notes[-1]}, fewer than {MIN_SAMPLES} are left; log all columns at one rate, "
                         "or delete the one that is empty")  # fmt: skip
    return log.only(~dropped), notes


def _in_contract(log: _Log, units: Mapping) -> tuple[_Log, list[str]]:
    """Columns in the contract's units, and a line on what was converted."""
    names, told, table = {}, {}, log.table.copy()
    for name in table.columns:
        unit, original = _suffix(name), log.originals.get(name, name)
        found = in_contract(name, units) if _MISSPELT.match(name) else None
        if found and (_COLUMN.match(found[0]) or found[0] == "t_s"):
            if found[0] in table.columns or found[0] in names.values():
                raise InputError(f"{log.header}: column {original}: {found[0]} is there too; keep one")
            names[name] = found[0]
            table[name] = table[name] * found[1]
            told.setdefault(f"{unit} converted to {_suffix(found[0])}, factor {found[1]:.6g}", []).append(original)
        elif unit in OF_THE_MACHINE and _MISSPELT.match(name):
            raise InputError(f"{log.header}: column {original}: how much is one {unit}?; say it with --units "
                             f"{unit}=FACTOR and unit, such as {unit}=0.05nm")  # fmt: skip
    notes = [f"{', '.join(own)}: {what}" for what, own in told.items()]
    return replace(log, table=table.rename(columns=names)), notes


def _without_marks(log: _Log) -> tuple[_Log, list[str]]:
    """The rows without a mark for a missing value, and a line per column on them."""
    is_marked, notes = np.zeros(len(log.table), bool), []
    for name in (name for name in log.table.columns if _MISSPELT.match(name) and not name.startswith("t_")):
        found = marks(log.table[name].to_numpy())
        if found:
            is_marked |= found[1]
            notes.append(f"{name}: {found[1].sum()} values of {found[0]:g} are marks for a missing value: left out")
    if not is_marked.any():
        return log, []
    if np.count_nonzero(~is_marked) < MIN_SAMPLES:
        raise InputError(f"{log.path}: {notes[0]}, and fewer than {MIN_SAMPLES} rows are left; give more")
    return log.only(~is_marked), notes


def _columns(log: _Log) -> dict[str, list[str]]:
    """Names of the columns by kind, in the order of the axes."""
    header = log.header
    found = _by_kind(header, log.table)
    n_axes = len(found["q"])
    if not n_axes:
        remedy = f"name {log.without_unit['q1']!r} with its unit" if "q1" in log.without_unit else (
            "add the position of each axis")  # fmt: skip
        raise InputError(f"{header}: column q1_m or q1_rad is missing in the header; {remedy}")
    for kind, by_axis in found.items():
        needed = kind == "q" or bool(by_axis)
        for axis in range(1, n_axes + 1) if needed else ():
            if axis not in by_axis:
                suffix = _SUFFIXES[kind][0]
                raise InputError(f"{header}: column {kind}{axis}_{suffix} is missing in the header; "
                                 f"axes are 1..{n_axes}")  # fmt: skip
        if len(by_axis) > n_axes:
            raise InputError(f"{header}: column {by_axis[max(by_axis)]} has no position column; add q{max(by_axis)}_m")
    for axis, name in found["v"].items():
        unit = _VELOCITY_OF[_suffix(found["q"][axis])]
        if _suffix(name) != unit:
            raise InputError(f"{header}: column {name} doesn't go with {found['q'][axis]}; give v{axis}_{unit}")
    if bool(found["f"]) == bool(found["i"]):
        wrong = "two kinds of effort" if found["f"] else "no effort"
        raise InputError(f"{header}: {wrong}; give one of column f1_n, f1_nm or i1_a, and so for all axes")
    return {kind: [by_axis[axis] for axis in sorted(by_axis)] for kind, by_axis in found.items()}


def _by_kind(header: str, table: pd.DataFrame) -> dict[str, dict[int, str]]:
    """Names of the columns by kind and axis. Columns of other names are left alone."""
    found = {kind: {} for kind in _SUFFIXES}
    for name in table.columns:
        match = _COLUMN.match(name)
        if match and match[3] in _SUFFIXES[match[1]]:
            if int(match[2]) in found[match[1]]:
                raise InputError(f"{header}: column {name}: axis {match[2]} has two columns of this kind; keep one")
            found[match[1]][int(match[2])] = name
        elif name not in ("t_s", "temp_c") and _MISSPELT.match(name):
            raise InputError(f"{header}: column {name} is not known; name it {_meant(name)}, or delete it")
    return found


def _meant(name: str) -> str:
    single, kind, axis = _MISSPELT.match(name.lower()).groups()
    if single:
        return {"t": "t_s", "temp": "temp_c"}[single]
    known = [unit for unit, (contract, _) in KNOWN.items() if contract in _SUFFIXES[kind]]
    if name.lower() == name and name.rsplit("_", 1)[1] in known:
        return name
    return " or ".join(f"{kind}{max(int(axis), 1)}_{suffix}" for suffix in _SUFFIXES[kind])


def _suffix(name: str) -> str:
    return name.rpartition("_")[2]


def _time(log: _Log) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Seconds, (n,), the run of each row, and lines on epochs and restarts."""
    table = log.table.to_numpy()
    if (table == table[0]).all():
        raise InputError(f"{log.path}: all {len(table)} rows are alike; log holds at several poses, or a motion")
    t_s, notes = clock.since_start(log.table["t_s"].to_numpy())
    run = clock.runs(t_s)
    if run is None:
        row = log.rows[np.flatnonzero(np.diff(t_s) < 0)[0] + 1]
        raise InputError(f"{log.path}: row {row}, column t_s: time runs backwards; sort the rows by time")
    if run.any():
        first = log.rows[int(np.argmax(run == 1))]
        notes.append(f"the clock restarts in row {first}: {run.max() + 1} runs, kept apart as segments")
    n_same = int(np.count_nonzero((np.diff(t_s) == 0) & (np.diff(run) == 0)))
    if n_same > clock.MOST_REPEATED * len(t_s):
        notes.append(f"t_s: {n_same} of {len(t_s)} rows have the stamp of the row before: spread evenly between stamps")
        t_s = clock.spread(t_s, run)
    elif n_same:
        notes.append(f"t_s: {n_same} rows have the stamp of the row before")
    return clock.joined(t_s, run), run, notes


def _effort(log: _Log, columns: dict, machine: Machine | None) -> tuple[np.ndarray, np.ndarray | None, tuple]:
    """Measured and predicted efforts (n, k), and their unit per axis: amperes of one beside N or Nm of the other become
    those by the machine's constant of the axis; without predictions all become those.
    """
    names, predicted = columns["f"] or columns["i"], columns["fm"]
    units, model_units = ([_UNITS[_suffix(name)] for name in kind] for kind in (names, predicted))
    force, nominal = _stack(log, names), _stack(log, predicted) if predicted else None
    if not force.any():
        raise InputError(
            f"{log.header}: columns {', '.join(names)} are zero in every row; log the effort of the motors"
        )
    for i, unit in enumerate(units):
        own = model_units[i] if predicted else ""
        if (unit == "A") == (own == "A"):
            continue
        per_ampere, unit_of_axis = _per_ampere(log, columns, machine)
        if unit == "A":
            force[:, i] *= per_ampere[i]
            units[i] = unit_of_axis[i]
        elif own == "A":
            nominal[:, i] *= per_ampere[i]
            model_units[i] = unit_of_axis[i]
    for name, unit, own in zip(predicted, units, model_units, strict=False):
        if unit != own:
            raise InputError(f"{log.header}: column {name} is in {own}, the effort in {unit}; give both in one unit")
    return force, nominal, tuple(units)


def _robot_behind(
    columns: dict, machine: Machine | None, q: np.ndarray, nominal: np.ndarray, units: tuple[str, ...]
) -> tuple[Robot | None, list[str]]:
    """The machine's robot, to tell what the log's own predictions do not: bodies, gravity, passive joints. None, and a
    line why, where the predictions are of another one.
    """
    if machine is None:
        return None, []
    aside = f"fm columns alone are the model, {machine.where} is left aside:"
    wanted = [f"q{k}_{unit}" for k, unit in enumerate(machine.position_units, start=1)]
    efforts = tuple(EFFORT_UNITS[unit] for unit in machine.position_units)
    if columns["q"] != wanted or units != efforts:
        return None, [f"{aside} it has {', '.join(wanted)} and efforts in {', '.join(dict.fromkeys(efforts))}"]
    try:
        off = np.sqrt(np.mean((machine.robot.forces(q) - nominal) ** 2) / max(np.mean(nominal**2), 1e-300))
    except PoseError as error:
        return None, [f"{aside} {error}"]
    if off > _OTHER_ROBOT:
        return None, [f"{aside} its efforts differ from them by {100 * off:.0f} % RMS"]
    return machine.robot, []


def _per_ampere(log: _Log, columns: dict, machine: Machine | None) -> tuple[np.ndarray, tuple[str, ...]]:
    """N or Nm per ampere of each axis (k,), and which of the two."""
    amperes = next(name for name in columns["i"] + columns["fm"] if name.endswith("_a"))
    n = len(columns["q"])
    if machine is None:
        raise InputError(f"{log.header}: column {amperes} is in amperes; give the machine folder with --robot, "
                         "the size with --units a=0.1nm, or one unit for all")  # fmt: skip
    wanted = [f"q{k}_{unit}" for k, unit in enumerate(machine.position_units, start=1)]
    if columns["q"] != wanted:
        raise InputError(f"{log.header}: column {amperes} is in amperes, but {machine.where} has {', '.join(wanted)}, "
                         f"the log {', '.join(columns['q'])}; give its folder, or --units a=0.1nm")  # fmt: skip
    return machine.drive.effort_per_ampere[:n], tuple(EFFORT_UNITS[unit] for unit in machine.position_units)


def _check_machine(log: _Log, columns: dict, machine: Machine | None) -> None:
    """Raise InputError unless the positions are those of the machine's axes, in its units, and the efforts too."""
    header, names = log.header, columns["q"]
    if machine is None:
        raise InputError(f"{header}: columns {', '.join(names)} without fm columns; add fm1_... with your model's "
                         "prediction, or give the machine folder with --robot")  # fmt: skip
    wanted = [f"q{k}_{unit}" for k, unit in enumerate(machine.position_units, start=1)]
    if names != wanted:
        raise InputError(f"{header}: columns {', '.join(names)} without fm columns, but {machine.where} has "
                         f"{', '.join(wanted)}; add fm1_... or give those")  # fmt: skip
    for name, unit in zip(columns["f"], machine.position_units, strict=False):  # no f columns where amperes are logged
        if _UNITS[_suffix(name)] != EFFORT_UNITS[unit]:
            raise InputError(f"{header}: column {name}: {machine.where} has it in {EFFORT_UNITS[unit]}; "
                             "add fm columns or give that unit")  # fmt: skip


def _statics(log: _Log, q: np.ndarray, machine: Machine) -> np.ndarray:
    try:
        return machine.robot.forces(q)
    except PoseError as error:
        row, last = log.rows[error.index or 0], f"q{machine.n_axes}_{machine.position_units[-1]}"
        raise InputError(f"{log.path}: row {row}, columns q1_{machine.position_units[0]}..{last}: outside the robot's "
                         "joint space; check zero and unit of the encoders") from error  # fmt: skip


def _stack(log: _Log, names: list[str]) -> np.ndarray:
    return log.table[names].to_numpy(dtype=float, copy=True)
