"""Periodogram of a residual over position or time: finds pitches, harmonics and frequencies without being told."""

import numpy as np
from numpy.polynomial.legendre import legvander

from gravcomp.diagnosis.thresholds import (
    DIVISORS,
    LARGER_PITCH,
    LINE_GRID,
    LINE_MAX_CYCLES,
    LINE_MIN_CYCLES,
    LINE_ODDS,
    LINE_RESOLUTION,
    LINE_STEPS,
    LINE_TREND,
    MAX_LINES,
    MAX_ORDER,
    ORDERS_APART,
    STEP_EDGE,
    TINY,
    TURN_RESOLUTION,
)


def spectrum(x: np.ndarray, r: np.ndarray, max_cycles: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (cycles per unit of x) and power of r (n, k) summed over columns, in units of white noise (about k).

    x (n,) or (n, k). Binned on a fine grid, then one FFT per column; padding fourfold gives the quarter-cycle step.
    """
    x = np.broadcast_to(np.atleast_2d(x.T).T, r.shape)
    span = max(np.ptp(x, axis=0).max(), TINY)
    power = 0.0
    for k in range(r.shape[1]):
        place = ((x[:, k] - x[:, k].min()) / span * (LINE_GRID - 1)).round().astype(int)
        binned = np.bincount(place, r[:, k] - r[:, k].mean(), LINE_GRID)
        power = power + np.abs(np.fft.rfft(binned, 4 * LINE_GRID)) ** 2 / max(np.sum(r[:, k] ** 2), TINY)
    f = np.arange(len(power)) / 4.0 / span * (LINE_GRID - 1) / LINE_GRID
    keep = (f * span >= LINE_MIN_CYCLES) & (f * span <= max_cycles)
    return f[keep], power[keep]


def find_lines(x: np.ndarray, r: np.ndarray, max_lines: int = MAX_LINES) -> list[tuple[float, float]]:
    """Significant spectral lines (frequency, power), strongest first, each removed before the next is sought."""
    n = len(r)
    limit = min(LINE_MAX_CYCLES, n / 3)
    x = np.broadcast_to(np.atleast_2d(x.T).T, r.shape)
    if not np.ptp(x, axis=0).all():
        return []
    trends, lines = _trends(x), []
    rest = np.column_stack([_without(trend, column) for trend, column in zip(trends, r.T, strict=True)])
    for _ in range(max_lines):
        f, power = spectrum(x, rest, limit)
        if not len(f):
            break
        best = int(power.argmax())
        # chance of such a peak among all frequencies, white noise: power is a sum of unit exponentials
        if power[best] < np.log(len(f)) + LINE_ODDS + 2.0 * np.sqrt(r.shape[1] * np.log(len(f))) * (r.shape[1] > 1):
            break
        frequency = _refine(x, rest, trends, f[best], f[1] - f[0])
        lines.append((frequency, float(power[best])))
        rest = rest - _wave(x, rest, trends, frequency)
    return lines


def _trends(x: np.ndarray) -> list[np.ndarray]:
    """Per column of x an orthonormal basis (n, p) of its polynomials: what is smooth over the range is no ripple."""
    centred = (x - x.mean(axis=0)) / (np.ptp(x, axis=0) / 2)
    return [np.linalg.qr(legvander(column, LINE_TREND))[0] for column in centred.T]


def _without(trend: np.ndarray, y: np.ndarray) -> np.ndarray:
    return y - trend @ (trend.T @ y)


def step_in(t: np.ndarray, r: np.ndarray) -> float:
    """The time at which r (n,) most clearly changes its level."""
    total = np.cumsum(r - r.mean())
    edge = max(int(STEP_EDGE * len(r)), 1)
    left = np.arange(1, len(r) + 1)
    gain = total**2 / (left * np.maximum(len(r) - left, 1))
    k = edge + int(gain[edge:-edge].argmax())
    return float(0.5 * (t[k] + t[min(k + 1, len(t) - 1)]))


def _wave(x, r, trends, frequency):
    """The part of r at a frequency; of few cycles the trend takes some, so it is taken from the wave, too."""
    out = np.empty_like(r)
    for k, trend in enumerate(trends):
        angle = 2 * np.pi * frequency * x[:, k]
        basis = _without(trend, np.column_stack([np.sin(angle), np.cos(angle)]))
        out[:, k] = basis @ np.linalg.lstsq(basis, r[:, k], rcond=None)[0]
    return out


def _refine(x, r, trends, frequency, step):
    """The frequency of the wave that takes most off r near a peak of the power: as a trend takes the more the fewer
    cycles there are, such a peak lies too high, by more than a step.
    """
    around = step * np.linspace(-1.0, 1.0, 21)
    for _ in range(LINE_STEPS):
        best = int(np.argmax([np.sum(_wave(x, r, trends, g) ** 2) for g in frequency + around]))
        frequency = float(frequency + around[best])
        if 0 < best < len(around) - 1:
            break
    return frequency


def pitch_of(
    lines: list[tuple[float, float]], span: float, turn: float | None, divisors: int = DIVISORS
) -> tuple[float, tuple[int, ...]] | None:
    """Pitch and harmonics that explain the lines: a full turn where the lines are whole orders of it, else the largest
    fundamental of which the strong lines are multiples within the resolution of a scan, LINE_RESOLUTION/span; the
    strongest line at least, which is one of the first ``divisors`` harmonics. Harmonics of one pitch are so far apart
    that they can be told from one another: any two lines are near to two of a pitch that is long enough.
    """
    if not lines:
        return None
    f, power = np.array(lines).T
    resolution = LINE_RESOLUTION / span
    bases = [f[0] / m for m in range(1, divisors + 1) if m == 1 or span * f[0] / m > ORDERS_APART]
    if turn is not None and span / turn > ORDERS_APART:
        bases = [1.0 / turn]
        resolution = TURN_RESOLUTION / span

    def fit(base):
        h = np.round(f / base)
        ok = (np.abs(f - h * base) < resolution) & (h >= 1) & (h <= (LINE_MAX_CYCLES if turn else MAX_ORDER))
        return power[ok].sum(), h[ok]

    scores = [fit(base)[0] * (LARGER_PITCH**m) for m, base in enumerate(bases)]
    base = bases[int(np.argmax(scores))]
    h = np.unique(fit(base)[1].astype(int))
    return (1.0 / base, tuple(int(k) for k in h)) if len(h) else None
