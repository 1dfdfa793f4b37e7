"""CSV files of poses, with or without efforts: the columns of measured data, q{i}_m|q{i}_rad, f{i}_n|f{i}_nm."""

import re
from pathlib import Path

import numpy as np
import pandas as pd

from gravcomp.errors import InputError

_EFFORTS = {"m": "n", "rad": "nm"}


def read_positions(path: Path, units: tuple[str, ...]) -> np.ndarray:
    """Positions (N, n) of axes with these units. Raises InputError naming file, row and column."""
    table = _read(path)
    return _columns(path, table, [f"q{k}_{unit}" for k, unit in enumerate(units, start=1)])


def read_samples(path: Path) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Units (n,), positions (N, n) and efforts (N, n), N for m and Nm for rad. Raises InputError."""
    table = _read(path)
    found = [re.fullmatch(r"q(\d+)_(m|rad)", name) for name in table.columns]
    by_axis = {int(match[1]): match[2] for match in found if match}
    if not by_axis or sorted(by_axis) != list(range(1, len(by_axis) + 1)) or len(by_axis) != sum(map(bool, found)):
        raise InputError(f"{path}: header: give columns q1_m or q1_rad, q2_... for the axes 1 to n, one for each")
    units = tuple(by_axis[k] for k in sorted(by_axis))
    q = _columns(path, table, [f"q{k}_{unit}" for k, unit in enumerate(units, start=1)])
    return units, q, _columns(path, table, [f"f{k}_{_EFFORTS[unit]}" for k, unit in enumerate(units, start=1)])


def _read(path: Path) -> pd.DataFrame:
    try:
        table = pd.read_csv(path, comment="#", skipinitialspace=True)
    except FileNotFoundError:
        raise InputError(f"{path}: not found; put the CSV there, or correct its name") from None
    except (OSError, ValueError) as error:  # pandas' errors of parsing are values'
        raise InputError(
            f"{path}: not a CSV file ({' '.join(str(error).split())}); give comma separated text"
        ) from error
    if table.empty:
        raise InputError(f"{path}: no rows below the header; give one per pose")
    return table.rename(columns=str.strip)


def _columns(path: Path, table: pd.DataFrame, names: list[str]) -> np.ndarray:
    for name in names:
        if name not in table:
            raise InputError(f"{path}: header: column {name} is missing; found {', '.join(map(str, table.columns))}")
    values = table[names].apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
    for row, column in np.argwhere(~np.isfinite(values)):
        name = names[column]
        found = table[name].iloc[row]
        raise InputError(f"{path}: row {row + 1}, column {name}: {found!r} is not a finite number; give one")
    return values
