"""What the log itself shows to be wrong with its columns, put right before anything is fitted, and said."""

from dataclasses import dataclass, replace

import numpy as np

from gravcomp.diagnosis.samples.outliers import spread
from gravcomp.diagnosis.samples.timing import put_right
from gravcomp.diagnosis.thresholds import (
    LEAK,
    SIGN_GAIN,
    TINY,
    TWO_VALUED,
    TWO_VALUED_SIDE,
    UNIT_FIT,
    UNIT_NEAR,
    UNIT_RIGHT,
)
from gravcomp.logs.measurement import Measurement, velocity_from_position

_FACTORS = {1000.0: "a thousand times", 1e-3: "a thousandth of", 180.0 / np.pi: "in degrees, 57.3 times",
            np.pi / 180.0: "0.01745 times", 60.0 / (2 * np.pi): "in turns per minute, 9.55 times"}  # fmt: skip


@dataclass(frozen=True)
class Checked:
    """The log with its columns put right, and a line on each."""

    data: Measurement
    notes: tuple[str, ...]


def check(data: Measurement) -> Checked:
    """Clocks and holds, velocities that are none, positions that read the effort back, in that order."""
    notes = list(data.notes)
    for step in (put_right, _standing, _velocity, _leakage):
        data, told = step(data)
        notes += told
    return Checked(data, tuple(notes))


def _standing(data: Measurement) -> tuple[Measurement, list[str]]:
    """Velocities that are zero in every row say nothing about the approach."""
    if data.v is None or data.v.any():
        return data, []
    return replace(data, v=None), ["v is zero in every row: friction is not testable; log the approach velocity"]


def _velocity(data: Measurement) -> tuple[Measurement, list[str]]:
    """v of a motion against dq/dt: its unit and its sign; where v is noisier, dq/dt is used."""
    if data.v is None or not data.is_ordered or len(data.t_s) < 30:
        return data, []
    slope = velocity_from_position(data.t_s, data.q, data.runs)
    v, notes = data.v.copy(), []
    for i in range(data.n_axes):
        own, told = v[:, i], slope[:, i]
        if data.is_held[i]:
            continue
        size = np.sqrt((own @ own) * (told @ told))
        if size == 0.0 or abs(own @ told) < UNIT_FIT * size:
            continue
        ratio = float(own @ told / (told @ told))
        if ratio < 0.0:
            notes.append(f"v{i + 1} has the wrong sign: dq{i + 1}/dt is its opposite; turned round")
            v[:, i], ratio = -own, -ratio
        if abs(ratio - 1.0) > UNIT_RIGHT:
            known = next((factor for factor in _FACTORS if abs(ratio / factor - 1.0) < UNIT_NEAR), None)
            if known:
                notes.append(f"v{i + 1} is {_FACTORS[known]} dq{i + 1}/dt: a unit; divided by {known:.6g}")
                v[:, i] /= known
            else:
                notes.append(f"v{i + 1} is {ratio:.3g} times dq{i + 1}/dt: check its unit and the time")
    data = replace(data, v=v) if notes else data
    return _cleaner_velocity(data, slope, notes)


def _cleaner_velocity(data: Measurement, slope: np.ndarray, notes: list[str]) -> tuple[Measurement, list[str]]:
    v = data.v.copy()
    for i in range(data.n_axes):
        if data.is_held[i]:
            continue
        rough, smooth = (np.sqrt(np.mean(np.diff(x[:, i], 2) ** 2) / 6.0) for x in (v, slope))
        off = np.sqrt(np.mean((v[:, i] - slope[:, i]) ** 2))
        usual = np.quantile(np.abs(slope[:, i]), 0.95)
        if rough > 3.0 * smooth and rough > 0.02 * usual and off < 3.0 * rough:
            notes.append(f"v{i + 1} is noisier than dq{i + 1}/dt, which is used in its place")
            v[:, i] = slope[:, i]
    return (replace(data, v=v), notes) if (v != data.v).any() else (data, notes)


def _leakage(data: Measurement) -> tuple[Measurement, list[str]]:
    """Deviations of the positions from their places that read the effort back: the places are used."""
    q, notes = data.q.copy(), []
    for i, own in enumerate(data.places):
        if own is None:
            continue
        off, force = _within(q[:, i] - own.centre, own.centre), _within(data.force[:, i], own.centre)
        size = np.sqrt((off @ off) * (force @ force))
        r = off @ force / size if size > 0.0 else 0.0
        if abs(r) > LEAK and np.ptp(off) > 0.0:
            notes.append(
                f"q{i + 1} stands off its places in proportion to the effort (correlation {r:.3f}): "
                "it reads the effort back, so the places are used"
            )
            q[:, i] = own.centre
    return (replace(data, q=q), notes) if notes else (data, notes)


def _within(x: np.ndarray, place: np.ndarray) -> np.ndarray:
    """x less its mean at each place, where places repeat, else less its mean."""
    _, of, count = np.unique(place, return_inverse=True, return_counts=True)
    if len(count) > 0.7 * len(x):
        return x - x.mean()
    return x - (np.bincount(of, x) / count)[of]


def inverted(data: Measurement) -> list[int]:
    """Axes (from 0) whose effort is the model's with the other sign."""
    gain = gains(data)
    return [i for i in range(data.n_axes) if SIGN_GAIN[0] < gain[i] < SIGN_GAIN[1] and _fits(data, i, gain[i])]


def gains(data: Measurement) -> np.ndarray:
    """Effort over model, (k,), by medians of the products; 1 where the model is zero."""
    out = np.ones(data.n_axes)
    for i in range(data.n_axes):
        f, m = data.force[:, i], data.nominal[:, i]
        use = np.abs(m) > 0.3 * np.abs(m).max() if m.any() else np.zeros(len(m), bool)
        if use.sum() >= 10:
            out[i] = np.median(f[use] / m[use])
    return out


def is_a_gain(gain: float) -> bool:
    """Is an effort over a model one of a motor, and not of another unit, sign or machine?"""
    return bool(0.5 < gain < 1.5)


def _fits(data: Measurement, i: int, gain: float) -> bool:
    f, m = data.force[:, i], data.nominal[:, i]
    return spread((f - gain * m)[:, None])[0] < 0.5 * spread((f - m)[:, None])[0] or np.ptp(m) < 1e-9 * np.abs(m).max()


def two_valued(residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Level and centre, (k,) each, of columns of (m, k) that take two values, centre +- level; level 0 of others.

    Two means; normal samples lie 2.7, evenly spread ones 3.5 of their inner deviations apart.
    """
    level, centre = np.zeros(residual.shape[1]), np.median(residual, axis=0)
    for i, r in enumerate(residual.T):
        cut = np.median(r)
        for _ in range(10):
            up = r > cut
            if not TWO_VALUED_SIDE < up.mean() < 1.0 - TWO_VALUED_SIDE:
                break
            cut = (r[up].mean() + r[~up].mean()) / 2.0
        if not TWO_VALUED_SIDE < up.mean() < 1.0 - TWO_VALUED_SIDE:
            continue
        apart = r[up].mean() - r[~up].mean()
        inner = np.sqrt((r[up].var() * up.sum() + r[~up].var() * (~up).sum()) / len(r))
        if apart > TWO_VALUED * max(inner, TINY):
            level[i], centre[i] = apart / 2.0, cut
    return level, centre
