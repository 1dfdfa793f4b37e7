"""Columns of a motion that come at other times than their stamps say: jitter of the clock, sample and hold."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from gravcomp.diagnosis.thresholds import (
    CLOCK_EVEN,
    CLOCK_JITTER,
    CLOCK_MISSING,
    CLOCK_ROWS,
    HELD_FRESH,
    HELD_KEEPS_UP,
    HELD_REGULAR,
    STUCK_CHANCE,
    STUCK_LEAP,
    STUCK_ROWS,
    STUCK_USUAL,
    TINY,
)
from gravcomp.logs.measurement import Measurement, velocity_from_position


def put_right(data: Measurement) -> tuple[Measurement, list[str]]:
    """The log of a motion on an even clock, with held columns drawn between their fresh values or left out."""
    if not data.is_ordered or len(data.t_s) < CLOCK_ROWS:
        return data, []
    is_derived = data.v is not None and np.array_equal(data.v, velocity_from_position(data.t_s, data.q, data.runs))
    notes: list[str] = []
    for step in (_even_clock, _held_positions):
        data, told = step(data)
        notes += told
    if notes and is_derived:
        data = replace(data, v=velocity_from_position(data.t_s, data.q, data.runs))
    for leave_out in (_held_efforts, _stuck_efforts):
        data, told = leave_out(data)
        notes += told
    return data, notes


def _even_clock(data: Measurement) -> tuple[Measurement, list[str]]:
    """Stamps that jitter where the samples do not: neighbours in q lie on a line over the rows, not over the stamps."""
    t_s, most = data.t_s.copy(), 0.0
    for run in np.unique(data.runs):
        rows = np.flatnonzero(data.runs == run)
        t, q = data.t_s[rows], data.scaled_positions[rows]
        step = np.diff(t)
        usual = np.median(step)
        if len(rows) < CLOCK_ROWS or step.std() < CLOCK_JITTER * usual or step.max() > CLOCK_MISSING * usual:
            return data, []
        part = (t[1:-1] - t[:-2]) / np.maximum(t[2:] - t[:-2], TINY)
        off = [np.std(q[1:-1] - q[:-2] - w[:, None] * (q[2:] - q[:-2])) for w in (part, np.full(len(part), 0.5))]
        if off[1] > CLOCK_EVEN * off[0]:
            return data, []
        t_s[rows] = np.polyval(np.polyfit(np.arange(len(t)), t, 1), np.arange(len(t)))
        most = max(most, float(np.std(t - t_s[rows])))
    note = f"t_s: the stamps jitter by {most:.2g} s where the positions are even: an even clock is used"
    return replace(data, t_s=t_s), [note]


def _held_positions(data: Measurement) -> tuple[Measurement, list[str]]:
    """Positions, speeds and predictions that a slower clock holds are drawn between their fresh values."""
    columns = {"q": data.q, "v": data.v, "fm": None if data.robot is not None else data.nominal}
    drawn, notes = {}, []
    for name, values in columns.items():
        for i in range(data.n_axes if values is not None else 0):
            held = _rows_held(values[:, i], data.runs)
            if held is None or (name == "q" and not _is_motion(data, i, held[1])):
                continue
            usual, fresh = held
            own = drawn.setdefault(name, values.copy())
            own[:, i] = _between(data, values[:, i], fresh)
            notes.append(f"{name}{i + 1} stands for {usual} rows at a time: drawn between its fresh values")
    if not drawn:
        return data, []
    q = drawn.get("q", data.q)
    nominal = data.robot.forces(q) if data.robot is not None else drawn.get("fm", data.nominal)
    return replace(data, q=q, v=drawn.get("v", data.v), nominal=nominal), notes


def _held_efforts(data: Measurement) -> tuple[Measurement, list[str]]:
    """Rows whose effort is that of a row before are left out: the pose has moved on since."""
    keep, notes = np.ones(len(data.t_s), bool), []
    for i in range(data.n_axes):
        held = _rows_held(data.force[:, i], data.runs)
        if held is not None and not data.is_held[i]:
            usual, fresh = held
            keep &= np.isin(np.arange(len(keep)), fresh)
            notes.append(f"the effort of axis {i + 1} stands for {usual} rows at a time: its fresh rows are used")
    return _with_rows(data, keep, notes)


def _stuck_efforts(data: Measurement) -> tuple[Measurement, list[str]]:
    """Rows of a stretch in which an effort stands at one value, and leaps from or to it, are left out: a bus that lost
    its words, a drive that was off.
    """
    keep, notes = np.ones(len(data.t_s), bool), []
    for i in range(data.n_axes):
        stuck = _rows_stuck(data.force[:, i], data.runs)
        if stuck.any() and not data.is_held[i]:
            keep &= ~stuck
            values = ", ".join(f"{value:g}" for value in np.unique(data.force[stuck, i])[:3])
            notes.append(f"the effort of axis {i + 1} is stuck at {values} in {stuck.sum()} rows: they are left out")
    return _with_rows(data, keep, notes)


def _rows_stuck(values: np.ndarray, runs: np.ndarray) -> np.ndarray:
    """Mask (n,) of stretches of one value that are longer than chance makes them, from how often neighbours are equal
    elsewhere, and with a leap at an end that is farther than nearly all steps.
    """
    step = np.abs(np.diff(values))
    starts = np.flatnonzero(np.concatenate([[True], (step != 0.0) | (np.diff(runs) != 0)]))
    length = np.diff(np.append(starts, len(values)))
    long = length >= STUCK_ROWS
    if not long.any():
        return np.zeros(len(values), bool)
    equal = (length[~long] - 1).sum() / max(length[~long].sum() - 1, 1)
    by_chance = len(values) * max(equal, 1.0 / len(values)) ** (length - 1.0)
    far = STUCK_LEAP * np.quantile(step[step > 0.0], STUCK_USUAL) if (step > 0.0).any() else np.inf
    padded = np.concatenate([[0.0], step, [0.0]])
    leaps = np.maximum(padded[starts], padded[starts + length]) > far
    return np.repeat(long & (by_chance < STUCK_CHANCE) & leaps, length)


def _with_rows(data: Measurement, keep: np.ndarray, notes: list[str]) -> tuple[Measurement, list[str]]:
    """The rows to keep (n,), with the notes on the others; as it is where too few would stay."""
    if not notes or keep.sum() < CLOCK_ROWS:
        return data, []
    arrays = {name: getattr(data, name) for name in ("t_s", "q", "v", "force", "nominal", "temp_c", "run", "unsure")}
    return replace(data, **{name: None if own is None else own[keep] for name, own in arrays.items()}), notes


def _rows_held(values: np.ndarray, runs: np.ndarray) -> tuple[int, np.ndarray] | None:
    """How many rows a value (n,) usually stands, and the rows at which it is fresh; None where no clock holds it."""
    is_new = (np.diff(values, prepend=np.nan) != 0.0) | (np.diff(runs, prepend=-1) != 0)
    fresh = np.flatnonzero(is_new)
    length = np.diff(fresh)
    if len(length) < 10 or np.median(length) < 2:
        return None
    usual = int(np.median(length))
    is_regular = np.mean(np.abs(length - usual) <= 1) > HELD_REGULAR
    return (usual, fresh) if is_regular and len(np.unique(values)) > HELD_FRESH * len(fresh) else None


def _between(data: Measurement, values: np.ndarray, fresh: np.ndarray) -> np.ndarray:
    """Values (n,) along a smooth curve through the fresh ones of each run; the last stands to its end."""
    out = values.copy()
    for run in np.unique(data.runs):
        rows, own = np.flatnonzero(data.runs == run), fresh[data.runs[fresh] == run]
        if len(own) > 2:
            t = np.minimum(data.t_s[rows], data.t_s[own[-1]])
            out[rows] = Akima1DInterpolator(data.t_s[own], values[own])(t)
    return out


def _is_motion(data: Measurement, i: int, fresh: np.ndarray) -> bool:
    """Do the steps between fresh positions keep to v?"""
    if data.v is None:
        return True
    step = np.diff(data.q[fresh, i])
    told = np.diff(np.interp(data.t_s[fresh], data.t_s, _integral(data.v[:, i], data.t_s)))
    return bool(np.sum(np.abs(step - told)) < HELD_KEEPS_UP * np.sum(np.abs(told)))


def _integral(v: np.ndarray, t_s: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t_s))])
