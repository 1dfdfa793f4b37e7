"""Single bad positions, as a bit that flipped leaves them: the rows beside them tell the right ones."""

import numpy as np

_SIDE = 2  # rows looked at on either side
_FAR = 5.0  # usual large steps beyond all rows beside it: no motion goes there and back within a row
_USUAL = 0.99
_MOST = 0.005  # of the rows: more are no accidents


def without_glitches(q: np.ndarray, run: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Positions (n, k) with glitches drawn between the rows beside them, and a line on each axis that had some."""
    out, notes = q.copy(), []
    if len(q) < 4 * _SIDE + 1:
        return out, notes
    for i, own in enumerate(q.T):
        bad = _glitches(own)
        if not 0 < bad.mean() <= _MOST:
            continue
        rows = np.arange(len(own))
        for k in np.unique(run[bad]):
            here = run == k
            out[here & bad, i] = np.interp(rows[here & bad], rows[here & ~bad], own[here & ~bad])
        notes.append(f"q{i + 1}: {bad.sum()} single positions far from the rows beside them are drawn between these")
    return out, notes


def _glitches(q: np.ndarray) -> np.ndarray:
    padded = np.pad(q, _SIDE, mode="reflect")
    beside = np.stack([padded[_SIDE + k : _SIDE + k + len(q)] for k in range(-_SIDE, _SIDE + 1) if k])
    outside = np.maximum(q - beside.max(axis=0), beside.min(axis=0) - q)
    return outside > _FAR * max(np.quantile(np.abs(np.diff(q)), _USUAL), 1e-9 * np.ptp(q))
