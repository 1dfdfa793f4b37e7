"""Signals of a file, each with its own clock and unit, as one measured CSV.

A signal becomes a column when its name is one that ``gravcomp.logs.headers`` knows, or when it is told to by
``--columns``: ``q1_deg=Axis1.Position``, or ``q1=Axis1.Position`` where the file tells the unit. ``q_rad=joints``,
without an axis, gives the columns of an array (n, k) to the axes 1..k.
"""

import csv
import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.logs.headers import column
from gravcomp.logs.units import unit_of_symbol

_NAMES_SHOWN = 12
_TARGET = re.compile(r"(t|temp|(?:q|v|f|i|fm)([1-9]\d*)?)(?:_([a-z]+))?")


@dataclass(frozen=True)
class Signal:
    """values (n,), or (n, k) of k axes; unit as the file tells it; t_s (n,): its own clock, None if it has none."""

    values: np.ndarray
    unit: str = ""
    t_s: np.ndarray | None = None


def parse_columns(pairs: list[str]) -> dict[str, str]:
    """``q1_deg=Position`` of a command line as {"q1_deg": "Position"}. Raises InputError."""
    out = {}
    for pair in pairs:
        target, _, name = pair.partition("=")
        if not name or not _TARGET.fullmatch(target):
            raise InputError(f"--columns {pair}: not COLUMN=SIGNAL; give t, q1, v1, f1, i1, fm1 or temp with a unit, "
                             "as in q1_deg=Position")  # fmt: skip
        out[target] = name
    return out


def measured_csv(path: Path, signals: Mapping[str, Signal], columns: Mapping[str, str]) -> str:
    """The measured CSV of the signals, on the clock of the first position. Raises InputError."""
    chosen = _chosen(path, signals, columns)
    first = next((name for name in sorted(chosen) if name.startswith("q")), None)
    if first is None:
        raise InputError(f"{path}: no position among its signals; say which is which with --columns t_s=... "
                         f"q1_deg=..., it has {_listed(signals)}")  # fmt: skip
    clock, comment = chosen[first].t_s, [f"from {path.name}"]
    if not any(name.startswith("t_") for name in chosen):
        if clock is None:
            clock, told = np.arange(len(chosen[first].values), dtype=float), "no clock: t_s counts the rows"
            comment.append(told)
        chosen = {"t_s": Signal(clock, t_s=clock), **chosen}
    rows = _on_one_clock(path, chosen, clock)
    stream = io.StringIO()
    stream.writelines(f"# {line}\n" for line in comment)
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(chosen)
    writer.writerows([repr(float(x)) if np.isfinite(x) else "" for x in row] for row in rows)
    return stream.getvalue()


def _chosen(path: Path, signals: Mapping[str, Signal], columns: Mapping[str, str]) -> dict[str, Signal]:
    """Signals by the name of their column, one axis each: those that were told, then those of a column's name."""
    out = {}
    for target, name in sorted(columns.items(), key=lambda pair: not pair[0].startswith("q")):  # q tells how many axes
        if name not in signals:
            raise InputError(f"{path}: no signal {name!r}; give one of {_listed(signals)}")
        n_axes = sum(own.startswith("q") for own in out)
        for k, values in enumerate(_by_axis(path, name, signals[name], target, n_axes), start=1):
            out[_column_name(path, name, signals[name].unit, target, k)] = Signal(values, t_s=signals[name].t_s)
    for name, signal in signals.items():
        found = column(name, signal.unit)
        if name not in columns.values() and found.kind and not found.should_be and not _is_told(found.name, columns):
            out.setdefault(found.name, signal)
    return out


def _is_told(name: str, columns: Mapping[str, str]) -> bool:
    return any(target.partition("_")[0] == name.partition("_")[0] for target in columns)


def _by_axis(path: Path, name: str, signal: Signal, target: str, n_axes: int) -> np.ndarray:
    """Values (k, n): one row, or one per axis where the column has no number; a vector then is that of every axis."""
    stem, axis, _ = _TARGET.fullmatch(target).groups()
    values = signal.values if signal.values.ndim == 2 else signal.values[:, None]
    if (axis or stem in ("t", "temp")) and values.shape[1] != 1:
        raise InputError(f"{path}: signal {name} has {values.shape[1]} columns; name them all, as in q_rad={name}")
    is_shared = not axis and stem not in ("t", "temp") and values.shape[1] == 1
    return np.repeat(values.T, max(n_axes, 1), axis=0) if is_shared else values.T


def _column_name(path: Path, name: str, unit: str, target: str, k: int) -> str:
    stem, axis, given = _TARGET.fullmatch(target).groups()
    known = given or unit_of_symbol(unit)
    if known is None:
        raise InputError(f"{path}: signal {name} has {f'the unit {unit!r}' if unit else 'no unit'}; "
                         f"say it, as in {target}_deg={name}")  # fmt: skip
    number = "" if axis or stem in ("t", "temp") else str(k)
    return f"{stem}{number}_{known}"


def _on_one_clock(path: Path, chosen: Mapping[str, Signal], clock: np.ndarray | None) -> np.ndarray:
    """Values (n, columns) at the clock's times that every signal covers: between two samples a straight line."""
    lengths = {len(signal.values) for signal in chosen.values()}
    if len(lengths) == 1 and (
        clock is None or all(s.t_s is None or np.array_equal(s.t_s, clock) for s in chosen.values())
    ):
        return np.column_stack([signal.values for signal in chosen.values()])
    for name, signal in chosen.items():
        if signal.t_s is None or clock is None:
            sizes = ", ".join(f"{own} {len(signal.values)}" for own, signal in chosen.items())
            raise InputError(
                f"{path}: columns differ in length and have no clock ({sizes}); choose others by --columns"
            )
        if not len(signal.values):
            raise InputError(f"{path}: column {name} has no sample; choose another by --columns")
    start, end = (pick(s.t_s[edge] for s in chosen.values()) for pick, edge in ((max, 0), (min, -1)))
    at = clock[(clock >= start) & (clock <= end)]
    return np.column_stack([_at(at, signal) for signal in chosen.values()])


def _at(t_s: np.ndarray, signal: Signal) -> np.ndarray:
    is_there = np.isfinite(signal.values)
    return (
        np.interp(t_s, signal.t_s[is_there], signal.values[is_there]) if is_there.any() else np.full(len(t_s), np.nan)
    )


def _listed(signals: Mapping[str, Signal]) -> str:
    names = sorted(signals)
    more = f" and {len(names) - _NAMES_SHOWN} more" if len(names) > _NAMES_SHOWN else ""
    return (", ".join(names[:_NAMES_SHOWN]) or "no signal at all") + more
