"""Reads the measured CSV: time, positions, velocities, efforts, temperature, predictions of the user's own model.

Columns: ``t_s``; per axis i ``q{i}_m`` or ``q{i}_rad``; optional ``v{i}_mps`` or ``v{i}_radps``; ``f{i}_n``,
``f{i}_nm`` or ``i{i}_a``; optional ``temp_c``; optional ``fm{i}_n``, ``fm{i}_nm`` or ``fm{i}_a``. # is a comment.
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd

from gravcomp.errors import InputError
from gravcomp.logs.force_surface import fit_force_function
from gravcomp.logs.measurement import Measurement, velocity_from_position
from gravcomp.robot.spheiro.kinematics import PoseError
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.statics import holding_forces_at

MIN_SAMPLES = 30
_LARGEST = 1e15  # of any measured value: sums of squares stay far from overflow, and a time in ns is noticed
_COLUMN = re.compile(r"^(q|v|f|i|fm)([1-9]\d*)_(m|rad|mps|radps|n|nm|a)$")
_SUFFIXES = {"q": ("m", "rad"), "v": ("mps", "radps"), "f": ("n", "nm"), "i": ("a",), "fm": ("n", "nm", "a")}
_VELOCITY_OF = {"m": "mps", "rad": "radps"}
# A name this close to a column's is one misspelt: it must not be left out unnoticed.
_MISSPELT = re.compile(r"^(?:(t|temp)|(q|v|f|i|fm)(\d+))_[a-z]+$", re.IGNORECASE)
_UNITS = {"n": "N", "nm": "Nm", "a": "A"}


def read_measurement(path: Path | str, robot: RobotParameters) -> Measurement:
    """Read one CSV; without fm columns the built-in robot's statics are the model (3 axes, metres).

    Raises InputError, one line naming file, row, column and what to do.
    """
    path = Path(path)
    table = _read_table(path)
    columns = _columns(path, table)
    n_axes = len(columns["q"])
    t_s = table["t_s"].to_numpy()
    _check_time(path, table, t_s)
    q = _stack(table, columns["q"])
    has_model = bool(columns["fm"])
    force, unit = _effort(path, table, columns, robot, has_model)
    v = _stack(table, columns["v"]) if columns["v"] else None
    if v is None:
        draft = Measurement(path.name, t_s, q, None, force, force, unit, ())
        v = velocity_from_position(t_s, q) if draft.is_ordered and (np.diff(t_s) > 0).all() else None
    if has_model:
        nominal = _stack(table, columns["fm"])
        if unit == "N" and columns["fm"][0].endswith("_a"):
            nominal = nominal * robot.thrust_constant_n_per_a
        force_at = fit_force_function(q, nominal, [_suffix(name) for name in columns["q"]])
    else:
        if n_axes != 3 or not all(name.endswith("_m") for name in columns["q"]):
            raise InputError(
                f"{path}: row {table.attrs['header_row']}: columns {', '.join(columns['q'])} without fm columns; "
                "add fm1_... with your model's prediction, or give q1_m, q2_m, q3_m of the built-in robot"
            )
        nominal, force_at = _built_in(path, table, q, robot), lambda at: holding_forces_at(at, robot)
    temp = table["temp_c"].to_numpy() if "temp_c" in table else None
    units = tuple(_suffix(name) for name in columns["q"])
    own = None if has_model else robot
    return Measurement(path.name, t_s, q, v, force, nominal, unit, units, temp, force_at, own)


def _read_table(path: Path) -> pd.DataFrame:
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
    if "t_s" not in header:
        hint = "separate columns by commas" if re.search("[;\t]", kept[0][1]) else "add the time in seconds"
        raise InputError(f"{path}: row {kept[0][0]}: column t_s is missing in the header; {hint}")
    if len(cells) < MIN_SAMPLES:
        raise InputError(f"{path}: row {kept[-1][0]}, column {header[0]}: only {len(cells)} samples; "
                         f"give at least {MIN_SAMPLES}")  # fmt: skip
    table = pd.DataFrame(cells, columns=header).apply(pd.to_numeric, errors="coerce")
    bad = ~(np.abs(table.to_numpy(dtype=float)) < _LARGEST)
    known = np.array([_COLUMN.match(name) is not None or name in ("t_s", "temp_c") for name in header])
    bad &= known
    if bad.any():
        k, j = np.argwhere(bad)[0]
        raise InputError(f"{path}: row {kept[1 + k][0]}, column {header[j]}: {cells[k][j].strip()!r} is not a finite "
                         f"number up to {_LARGEST:g}; correct or delete that row")  # fmt: skip
    table.attrs |= {"header_row": kept[0][0], "rows": [row for row, _ in kept[1:]]}
    return table.astype(float)


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
    return " or ".join(f"{kind}{max(int(axis), 1)}_{suffix}" for suffix in _SUFFIXES[kind])


def _suffix(name: str) -> str:
    return name.rsplit("_", 1)[1]


def _check_time(path: Path, table: pd.DataFrame, t_s: np.ndarray) -> None:
    back = np.flatnonzero(np.diff(t_s) < 0)
    if back.size:
        row = table.attrs["rows"][back[0] + 1]
        raise InputError(f"{path}: row {row}, column t_s: time runs backwards; sort the rows by time")


def _effort(path, table, columns, robot, has_model) -> tuple[np.ndarray, str]:
    header = f"{path}: row {table.attrs['header_row']}"
    names = columns["f"] or columns["i"]
    units = {_UNITS[_suffix(name)] for name in names}
    model_units = {_UNITS[_suffix(name)] for name in columns["fm"]}
    if len(units) > 1 or len(model_units) > 1:
        raise InputError(f"{header}: columns {', '.join(names + columns['fm'])} mix units; use one unit for all axes")
    force, unit = _stack(table, names), units.pop()
    if not force.any():
        raise InputError(f"{header}: columns {', '.join(names)} are zero in every row; log the effort of the motors")
    in_amperes = unit == "A" and (not has_model or model_units == {"N"})
    if in_amperes:
        force, unit = force * robot.thrust_constant_n_per_a, "N"
    if has_model and model_units != {unit} and not (unit == "N" and model_units == {"A"}):
        raise InputError(f"{header}: column {columns['fm'][0]} is in {model_units.pop()}, the effort in {unit}; "
                         "give both in one unit")  # fmt: skip
    if not has_model and unit == "Nm":
        raise InputError(f"{header}: column {names[0]}: the built-in robot needs N; add fm columns or give f1_n")
    return force, unit


def _built_in(path: Path, table: pd.DataFrame, q: np.ndarray, robot: RobotParameters) -> np.ndarray:
    try:
        return holding_forces_at(q, robot)
    except PoseError as error:
        row = table.attrs["rows"][int(re.search(r"pose (\d+)", str(error))[1])]
        raise InputError(f"{path}: row {row}, columns q1_m..q3_m: outside the robot's joint space; "
                         "check zero and unit of the encoders") from error  # fmt: skip


def _stack(table: pd.DataFrame, names: list[str]) -> np.ndarray:
    return table[names].to_numpy(dtype=float)
