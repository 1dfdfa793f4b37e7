"""The clock of a log: epochs, runs that were joined, stamps that stand still."""

import numpy as np

# Seconds since 1970 in one of these steps are this large; no log of its own clock is.
_EPOCHS = ((1e17, "ns", 1e-9), (1e14, "us", 1e-6), (1e11, "ms", 1e-3), (1e9, "s", 1.0))
MOST_REPEATED = 0.1  # of the rows: a clock that repeats more is coarser than the log, and rows lie between its stamps
_MOST_RUNS = 0.1  # of the rows: with more drops of the clock the rows are out of order


def since_start(t: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Seconds since the first row of a clock that counts from 1970, and a word on it; other clocks as they are."""
    for least, unit, step_s in _EPOCHS:
        if np.median(t) > least:
            return (t - t[0]) * step_s, [f"t_s is a time since 1970 in {unit}: seconds since the first row are used"]
    return t, []


def runs(t_s: np.ndarray) -> np.ndarray | None:
    """Number of the run that each row belongs to, (n,): a new one where the clock drops and stays behind.

    None where a drop is no restart: rows out of order.
    """
    drops = np.flatnonzero(np.diff(t_s) < 0) + 1
    if len(drops) > max(_MOST_RUNS * len(t_s), 1):
        return None
    for k in drops:
        following = t_s[k + 1] if k + 1 < len(t_s) else np.inf
        if following >= t_s[k - 1]:
            return None
    return np.searchsorted(drops, np.arange(len(t_s)), side="right")


def joined(t_s: np.ndarray, run: np.ndarray) -> np.ndarray:
    """One clock over all runs: each begins one usual step after the end of the last."""
    out, step = t_s.astype(float), usual_step(t_s, run)
    for k in range(1, int(run.max()) + 1 if len(run) else 0):
        first = int(np.argmax(run == k))
        out[run == k] += out[first - 1] + step - t_s[first]
    return out


def spread(t_s: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Stamps of a clock that is coarser than the log: rows lie evenly between a stamp and the next of their run."""
    out = t_s.astype(float)
    for k in np.unique(run):
        rows = np.flatnonzero(run == k)
        stamps, first, count = np.unique(t_s[rows], return_index=True, return_counts=True)
        if len(stamps) < 2:
            continue
        end = stamps[-1] + (stamps[-1] - stamps[0]) / first[-1] * count[-1]
        out[rows] = np.interp(np.arange(len(rows)), [*first, len(rows)], [*stamps, end])
    return out


def usual_step(t_s: np.ndarray, run: np.ndarray) -> float:
    step = np.diff(t_s)[np.diff(run) == 0]
    return float(np.median(step[step > 0])) if (step > 0).any() else 1.0


def derivative(values: np.ndarray, t_s: np.ndarray, run: np.ndarray, window: int, smooth) -> np.ndarray:
    """d values/dt (n, k), run by run, of values smoothed by smooth(values, window); rows of one stamp are one row."""
    out = np.zeros_like(values)
    for k in np.unique(run):
        rows = np.flatnonzero(run == k)
        stamps, first, of = np.unique(t_s[rows], return_index=True, return_inverse=True)
        if len(stamps) < 3:
            continue
        own = values[rows[first]]
        own = smooth(own, window) if len(stamps) > window else own
        out[rows] = np.gradient(own, stamps, axis=0)[of]
    return out
