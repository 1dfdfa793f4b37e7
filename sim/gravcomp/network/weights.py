"""A trained network and its folder of CSV files.

y = S_o (W_o^T Gamma(W_H^T S_i x + b_H) + b_o), written out:
x = (q - q_offset) q_scale, or sin and cos of q - q_offset;  h = Gamma(W x + b_H);  f = f_offset + f_scale (V h + b_o).
"""

import csv
import math
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically
from gravcomp.network.activation import gamma
from gravcomp.network.inputs import POSITION, SIN_COS, inputs_of, weight_columns

HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV = "hidden.csv", "output.csv", "scaling.csv"
_SCALING_COLUMNS = ("q_offset", "q_scale", "f_offset", "f_scale")
_SCALING_HEADER = ["axis", "position_unit", *_SCALING_COLUMNS]
# As written before axes had units of their own: metres and newtons.
_OLDER_SCALING_HEADER = ["axis", "q_offset_m", "q_scale_per_m", "f_offset_n", "f_scale_n"]
UNITS = ("m", "rad")


@dataclass(frozen=True)
class Network:
    """A network with one hidden layer; n axes, p inputs, h hidden neurons, an output per axis.

    hidden_weights W (h, p), hidden_bias b_H (h,), output_weights V (n, h), output_bias b_o (n,): no unit.
    q_offset (n,) m or rad, as position_units say; q_scale (n,) 1/m or 1/rad; f_offset, f_scale (n,) N, or Nm for rad.
    inputs (n,): position or sin_cos, what the network sees of each axis.
    """

    hidden_weights: np.ndarray
    hidden_bias: np.ndarray
    output_weights: np.ndarray
    output_bias: np.ndarray
    q_offset: np.ndarray
    q_scale: np.ndarray
    f_offset: np.ndarray
    f_scale: np.ndarray
    position_units: tuple[str, ...]
    inputs: tuple[str, ...] = ()

    def __post_init__(self):
        if SIN_COS not in self.inputs:
            object.__setattr__(self, "inputs", (POSITION,) * len(self.q_offset))

    @property
    def n_hidden(self) -> int:
        return len(self.hidden_bias)

    @property
    def n_axes(self) -> int:
        return len(self.output_bias)

    def forces(self, q: np.ndarray, activation: Callable = gamma) -> np.ndarray:
        """Efforts f (..., n), N or Nm, at joint positions q (..., n), m or rad, in floating point."""
        return self.forces_of(self.x(q), activation)

    def x(self, q: np.ndarray) -> np.ndarray:
        """Inputs (..., p) of the hidden layer at joint positions q (..., n), m or rad."""
        return inputs_of(q, self.q_offset, self.q_scale, self.inputs)

    def forces_of(self, x: np.ndarray, activation: Callable = gamma) -> np.ndarray:
        """Efforts f (..., n), N or Nm, at inputs x (..., p) of the hidden layer."""
        hidden = activation(x @ self.hidden_weights.T + self.hidden_bias)
        return self.f_offset + self.f_scale * (hidden @ self.output_weights.T + self.output_bias)


def save_network(network: Network, folder: Path | str) -> None:
    """Write hidden.csv, output.csv and scaling.csv, floats in full precision. Raises InputError if it cannot."""
    folder = Path(folder)
    neurons = range(1, network.n_hidden + 1)
    output_header = ["axis", *(f"v_{k}" for k in neurons), "bias"]
    hidden = _csv_text(_hidden_header(network.inputs), np.c_[network.hidden_weights, network.hidden_bias])
    output = _csv_text(output_header, np.c_[network.output_weights, network.output_bias])
    values = np.stack([getattr(network, name) for name in _SCALING_COLUMNS], axis=1)
    scaling = _csv_text(_SCALING_HEADER, values, network.position_units)
    write_all_atomically({folder / HIDDEN_CSV: hidden, folder / OUTPUT_CSV: output, folder / SCALING_CSV: scaling})


def load_network(folder: Path | str) -> Network:
    """Read a weights folder, from whatever tool wrote it.

    Raises InputError naming file, row and column when a file is missing or not CSV, a column is missing or unknown,
    a value is not a finite number, a scale is not positive, or the numbers of rows do not fit together.
    """
    folder = Path(folder)
    scaling, units = _read_scaling(folder / SCALING_CSV)
    n_axes = len(scaling)
    lines = _read_lines(folder / HIDDEN_CSV, _hidden_header((POSITION,) * n_axes))
    inputs = _inputs_in(lines[0], n_axes)
    hidden = _table(folder / HIDDEN_CSV, lines, _hidden_header(inputs))
    n_hidden = len(hidden)
    output_header = ["axis", *(f"v_{k}" for k in range(1, n_hidden + 1)), "bias"]
    output = _read_table(folder / OUTPUT_CSV, output_header)
    if len(output) != n_axes:
        raise InputError(
            f"{folder / OUTPUT_CSV}: {len(output)} rows, but {SCALING_CSV} has {n_axes} axes; give one row per axis"
        )
    for name in ("q_scale", "f_scale"):
        column = 1 + _SCALING_COLUMNS.index(name)
        for row in np.flatnonzero(scaling[:, column - 1] <= 0):
            value = scaling[row, column - 1]
            raise InputError(f"{folder / SCALING_CSV}: row {row + 1}, column {name}: {value} must be positive")
    return Network(hidden[:, :-1], hidden[:, -1], output[:, :-1], output[:, -1], *scaling.T, units, inputs)


def network_bytes(folder: Path | str) -> bytes:
    """The three CSV files in the order hidden, output, scaling."""
    return b"".join((Path(folder) / name).read_bytes() for name in (HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV))


def _read_scaling(path: Path) -> tuple[np.ndarray, tuple[str, ...]]:
    """Values (n, 4) and units of scaling.csv."""
    lines = _read_lines(path, _SCALING_HEADER)
    if [name.strip() for name in lines[0]] == _OLDER_SCALING_HEADER:
        values = _table(path, lines, _OLDER_SCALING_HEADER)
        return values, ("m",) * len(values)
    _check_header(path, lines[0], _SCALING_HEADER)
    units = []
    for number, line in enumerate(lines[1:], start=1):
        unit = line[1].strip() if len(line) > 1 else ""
        if len(line) == len(_SCALING_HEADER) and unit not in UNITS:
            raise InputError(f"{path}: row {number}, column position_unit: {unit!r}; give one of {', '.join(UNITS)}")
        units.append(unit)
    rest = [[cell for k, cell in enumerate(line) if k != 1] for line in lines]
    return _table(path, rest, ["axis", *_SCALING_COLUMNS]), tuple(units)


def _hidden_header(inputs: Sequence[str]) -> list[str]:
    return ["neuron", *weight_columns(inputs), "bias"]


def _inputs_in(header: list[str], n_axes: int) -> tuple[str, ...]:
    """What the columns of hidden.csv say that the network sees."""
    found = {name.strip() for name in header}
    return tuple(SIN_COS if found & {f"w_sin{i}", f"w_cos{i}"} else POSITION for i in range(1, n_axes + 1))


def _csv_text(header: list[str], rows: np.ndarray, words: Sequence[str] = ()) -> str:
    """Text of a numbered table; words, if any, stand between number and values."""
    lines = [",".join(header)]
    for number, row in enumerate(rows, start=1):
        lines.append(",".join([str(number), *words[number - 1 : number], *(repr(float(v)) for v in row)]))
    return "\n".join(lines) + "\n"


def _read_table(path: Path, header: list[str]) -> np.ndarray:
    """Values of a numbered table without its first column; rows must be numbered 1, 2, 3 ..."""
    return _table(path, _read_lines(path, header), header)


def _read_lines(path: Path, header: list[str]) -> list[list[str]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [line for line in csv.reader(file, strict=True) if line]
    except FileNotFoundError:
        folder = shlex.quote(str(path.parent))
        raise InputError(
            f"{path}: not found; `gravcomp train --robot {folder} --out {folder}` writes {HIDDEN_CSV}, {OUTPUT_CSV} "
            f"and {SCALING_CSV}"
        ) from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a CSV file ({error}); give comma separated text") from error
    if not lines:
        raise InputError(f"{path}: empty; its first line must be {','.join(header)}")
    return lines


def _table(path: Path, lines: list[list[str]], header: list[str]) -> np.ndarray:
    _check_header(path, lines[0], header)
    if len(lines) == 1:
        raise InputError(f"{path}: no rows below the header; give one per {header[0]}")
    values = [_read_row(path, number, line, header) for number, line in enumerate(lines[1:], start=1)]
    return np.array(values)


def _check_header(path: Path, line: list[str], header: list[str]) -> None:
    found = [name.strip() for name in line]
    for name in header:
        if name not in found:
            raise InputError(f"{path}: row 0 (header): column {name} is missing; the header must be {_short(header)}")
    if found != header:
        raise InputError(f"{path}: row 0 (header): found {_short(found)}; the header must be {_short(header)}")


def _read_row(path: Path, number: int, line: list[str], header: list[str]) -> list[float]:
    if len(line) != len(header):
        raise InputError(f"{path}: row {number}: {len(line)} columns instead of {len(header)}; complete the row")
    if line[0].strip() != str(number):
        raise InputError(
            f"{path}: row {number}, column {header[0]}: {line[0]!r} instead of {number}; number the rows 1, 2, 3 ..."
        )
    return [_read_number(path, number, name, text) for name, text in zip(header[1:], line[1:], strict=True)]


def _read_number(path: Path, row: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}: row {row}, column {column}: {text!r} is not a finite number; give one")
    return value


def _short(names: list[str]) -> str:
    return ",".join(names if len(names) <= 8 else [*names[:3], "...", *names[-2:]])
