"""Reads the measured CSV: time, positions, velocities, efforts, temperature, predictions of the user's own model.

Columns: ``t_s``; per axis i ``q{i}_m`` or ``q{i}_rad``; optional ``v{i}_mps`` or ``v{i}_radps``; ``f{i}_n``,
``f{i}_nm`` or ``i{i}_a``; optional ``temp_c``; optional ``fm{i}_n``, ``fm{i}_nm`` or ``fm{i}_a``; other known units
are converted. # is a comment.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from gravcomp.errors import InputError
from gravcomp.logs import clock
from gravcomp.logs.force_surface import fit_force_function
from gravcomp.logs.measurement import Measurement, velocity_from_position
from gravcomp.logs.missing import marks
from gravcomp.logs.units import KNOWN, OF_THE_MACHINE, in_contract
from gravcomp.robot.machine import EFFORT_UNITS, Machine
from gravcomp.robot.protocol import PoseError

MIN_SAMPLES = 30
_LARGEST = 1e15  # of any measured value: sums of squares stay far from overflow
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
    path, notes = Path(path), []
    table, told = _without_marks(path, _read_table(path, units or {}))
    notes += told
    table, told = _in_contract(path, table, units or {})
    notes += told
    columns = _columns(path, table)
    t_s, run, told = _time(path, table)
    notes += told
    q = _stack(table, columns["q"])
    has_model = bool(columns["fm"])
    force, by_axis = _effort(path, table, columns, machine)
    unit = ", ".join(dict.fromkeys(by_axis))
    v = _stack(table, columns["v"]) if columns["v"] else None
    if v is None:
        draft = Measurement(path.name, t_s, q, None, force, force, unit, (), run=run)
        v = velocity_from_position(t_s, q, run) if draft.is_ordered and np.ptp(t_s) > 0 else None
    if has_model:
        nominal = _stack(table, columns["fm"])
        if unit != "A" and columns["fm"][0].endswith("_a"):
            nominal = nominal * _per_ampere(path, table, columns, machine)
        force_at = fit_force_function(q, nominal, [_suffix(name) for name in columns["q"]])
    else:
        _check_machine(path, table, columns, machine)
        nominal, force_at = _statics(path, table, q, machine), machine.robot.forces
    return Measurement(
        path.name, t_s, q, v, force, nominal, unit, tuple(_suffix(name) for name in columns["q"]),
        temp_c=table["temp_c"].to_numpy() if "temp_c" in table else None, force_at=force_at,
        robot=None if has_model else machine.robot, run=run if run.any() else None,
        units=by_axis if len(set(by_axis)) > 1 else (), notes=tuple(notes), n_dropped=table.attrs["n_dropped"],
    )  # fmt: skip


def _read_table(path: Path, units: Mapping) -> pd.DataFrame:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a CSV text file") from error
    kept = [(row, line) for row, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not kept:
        raise InputError(f"{path}: row 1: no header line; give t_s, q1_m, ... and one row per sample")
    header = [name.strip() for name in kept[0][1].split(",")]
    for name in header:
        if header.count(name) > 1:
            raise InputError(f"{path}: row {kept[0][0]}: column {name!r} appears twice; keep one")
    cells = []
    for row, line in kept[1:]:
        parts = line.split(",")
        if len(parts) != len(header):
            raise InputError(f"{path}: row {row}: {len(parts)} values for {len(header)} columns, column "
                             f"{header[min(len(parts), len(header) - 1)]}; give one value per column")  # fmt: skip
        cells.append(parts)
    if not {"t_s", "t_ms", "t_us", "t_ns"} & {*header}:
        hint = "separate columns by commas" if re.search("[;\t]", kept[0][1]) else "add the time in seconds"
        raise InputError(f"{path}: row {kept[0][0]}: column t_s is missing in the header; {hint}")
    if len(cells) < MIN_SAMPLES:
        raise InputError(f"{path}: row {kept[-1][0]}, column {header[0]}: only {len(cells)} samples; "
                         f"give at least {MIN_SAMPLES}")  # fmt: skip
    table = pd.DataFrame(cells, columns=header).apply(pd.to_numeric, errors="coerce")
    is_time = np.array([name.startswith("t_") for name in header])
    bad = ~(np.abs(table.to_numpy(dtype=float)) < np.where(is_time, 1e20, _LARGEST))
    contract = [(in_contract(name, units) or (name,))[0] for name in header]
    bad &= [_COLUMN.match(name) is not None or name in ("t_s", "temp_c") for name in contract]
    if bad.any():
        k, j = np.argwhere(bad)[0]
        raise InputError(f"{path}: row {kept[1 + k][0]}, column {header[j]}: {cells[k][j].strip()!r} is not a finite "
                         f"number up to {_LARGEST:g}; correct or delete that row")  # fmt: skip
    table.attrs |= {"header_row": kept[0][0], "rows": [row for row, _ in kept[1:]], "n_dropped": 0}
    return table.astype(float)


def _in_contract(path: Path, table: pd.DataFrame, units: Mapping) -> tuple[pd.DataFrame, list[str]]:
    """Columns in the contract's units, and a line on what was converted."""
    names, told = {}, {}
    for name in table.columns:
        unit = _suffix(name)
        found = in_contract(name, units) if _MISSPELT.match(name) else None
        if found and (_COLUMN.match(found[0]) or found[0] == "t_s"):
            if found[0] in table.columns or found[0] in names.values():
                raise InputError(f"{path}: row {table.attrs['header_row']}: column {name}: {found[0]} is there too; "
                                 "keep one")  # fmt: skip
            names[name] = found[0]
            table[name] = table[name] * found[1]
            told.setdefault(f"{unit} converted to {_suffix(found[0])}, factor {found[1]:.6g}", []).append(name)
        elif unit in OF_THE_MACHINE and _MISSPELT.match(name):
            raise InputError(f"{path}: row {table.attrs['header_row']}: column {name}: how much is one {unit}?; "
                             f"say it with --units {unit}=FACTOR and unit, such as {unit}=0.05nm")  # fmt: skip
    attributes = table.attrs
    table = table.rename(columns=names)
    table.attrs |= attributes
    return table, [f"{', '.join(own)}: {what}" for what, own in told.items()]


def _without_marks(path: Path, table: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """The table without rows that hold a mark for a missing value, and a line per column on them."""
    is_marked, notes = np.zeros(len(table), bool), []
    for name in (name for name in table.columns if _MISSPELT.match(name) and not name.startswith("t_")):
        found = marks(table[name].to_numpy())
        if found:
            is_marked |= found[1]
            notes.append(f"{name}: {found[1].sum()} values of {found[0]:g} are marks for a missing value: left out")
    if not is_marked.any():
        return table, []
    if np.count_nonzero(~is_marked) < MIN_SAMPLES:
        raise InputError(f"{path}: {notes[0]}, and fewer than {MIN_SAMPLES} rows are left; give more")
    attributes = table.attrs
    table = table[~is_marked]
    rows = [row for row, marked in zip(attributes["rows"], is_marked, strict=True) if not marked]
    table.attrs |= {**attributes, "rows": rows, "n_dropped": int(is_marked.sum())}
    return table, notes


def _columns(path: Path, table: pd.DataFrame) -> dict[str, list[str]]:
    """Names of the columns by kind, in the order of the axes."""
    header = f"{path}: row {table.attrs['header_row']}"
    found = _by_kind(header, table)
    n_axes = len(found["q"])
    if not n_axes:
        raise InputError(f"{header}: column q1_m or q1_rad is missing in the header; add the position of each axis")
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


def _time(path: Path, table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Seconds, (n,), the run of each row, and lines on epochs and restarts."""
    t_s, notes = clock.since_start(table["t_s"].to_numpy())
    run = clock.runs(t_s)
    if run is None:
        row = table.attrs["rows"][np.flatnonzero(np.diff(t_s) < 0)[0] + 1]
        raise InputError(f"{path}: row {row}, column t_s: time runs backwards; sort the rows by time")
    if run.any():
        first = table.attrs["rows"][int(np.argmax(run == 1))]
        notes.append(f"the clock restarts in row {first}: {run.max() + 1} runs, kept apart as segments")
    n_same = int(np.count_nonzero((np.diff(t_s) == 0) & (np.diff(run) == 0)))
    if n_same:
        notes.append(f"t_s: {n_same} rows have the stamp of the row before")
    return clock.joined(t_s, run), run, notes


def _effort(
    path: Path, table: pd.DataFrame, columns: dict, machine: Machine | None
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Efforts (n, k) and their unit per axis; the model must have the same ones."""
    header = f"{path}: row {table.attrs['header_row']}"
    names, has_model = columns["f"] or columns["i"], bool(columns["fm"])
    units = tuple(_UNITS[_suffix(name)] for name in names)
    model_units = tuple(_UNITS[_suffix(name)] for name in columns["fm"])
    if len(set(units)) > 1 and units != model_units:
        raise InputError(f"{header}: columns {', '.join(names + columns['fm'])} mix units; use one unit for all axes, "
                         "or give fm columns in the unit of each")  # fmt: skip
    if len(set(model_units)) > 1 and units != model_units:
        raise InputError(f"{header}: columns {', '.join(names + columns['fm'])} mix units; use one unit for all axes")
    force = _stack(table, names)
    if not force.any():
        raise InputError(f"{header}: columns {', '.join(names)} are zero in every row; log the effort of the motors")
    if len(set(units)) > 1:
        return force, units
    unit, model_unit = units[0], (model_units or ("",))[0]
    if unit == "A" and model_unit != "A":
        force = force * _per_ampere(path, table, columns, machine)
        return force, tuple(EFFORT_UNITS[unit] for unit in machine.position_units)
    if has_model and model_unit != unit and model_unit != "A":
        raise InputError(f"{header}: column {columns['fm'][0]} is in {model_unit}, the effort in {unit}; "
                         "give both in one unit")  # fmt: skip
    return force, (unit,) * len(names)


def _per_ampere(path: Path, table: pd.DataFrame, columns: dict, machine: Machine | None) -> np.ndarray:
    """N or Nm per ampere of each axis (n,)."""
    if machine is None:
        amperes = next(name for name in columns["i"] + columns["fm"] if name.endswith("_a"))
        raise InputError(f"{path}: row {table.attrs['header_row']}: column {amperes} is in amperes; give the machine "
                         "folder with --robot, or one unit for all")  # fmt: skip
    _check_machine(path, table, columns, machine)
    return machine.drive.effort_per_ampere


def _check_machine(path: Path, table: pd.DataFrame, columns: dict, machine: Machine | None) -> None:
    """Raise InputError unless the positions are those of the machine's axes, in its units, and the efforts too."""
    header, names = f"{path}: row {table.attrs['header_row']}", columns["q"]
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


def _statics(path: Path, table: pd.DataFrame, q: np.ndarray, machine: Machine) -> np.ndarray:
    try:
        return machine.robot.forces(q)
    except PoseError as error:
        row, last = table.attrs["rows"][error.index or 0], f"q{machine.n_axes}_{machine.position_units[-1]}"
        raise InputError(f"{path}: row {row}, columns q1_{machine.position_units[0]}..{last}: outside the robot's "
                         "joint space; check zero and unit of the encoders") from error  # fmt: skip


def _stack(table: pd.DataFrame, names: list[str]) -> np.ndarray:
    return table[names].to_numpy(dtype=float)
