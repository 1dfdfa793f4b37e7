"""What is left after the fit: does it follow any measured variable, and which?"""

import numpy as np
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.inspection import permutation_importance
from sklearn.model_selection import GroupKFold

from gravcomp.diagnosis.corrections import variable, variable_names

_MIN_SAMPLES = 400
_MAX_SAMPLES = 2500
_MIN_R2 = 0.05
_MIN_SHARE = 0.003
_FOLDS = 4


def find(data, after, rows, blocks, noise, seed: int) -> list[dict]:
    """Drivers of structure that neither effects nor corrections took: axis, variable, share of what is left.

    Random trees over all variables, cross-validated by blocks; it counts when they predict more than 5 % of the
    variance on average, some in every fold, and the mean is four standard errors above zero.
    """
    rows = rows[~data.is_undecided[rows].any(axis=1)]
    if len(rows) < _MIN_SAMPLES:
        return []
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), _MAX_SAMPLES)).astype(int)]
    names = variable_names(data)
    x = np.column_stack([variable(data, name)[rows] for name in names])
    out = []
    for axis in range(data.n_axes):
        y = np.clip(after[rows, axis], -4 * noise[axis], 4 * noise[axis])
        gains, importance = [], np.zeros(len(names))
        for train, test in GroupKFold(_FOLDS).split(x, y, blocks[rows]):
            model = ExtraTreesRegressor(40, min_samples_leaf=10, random_state=seed).fit(x[train], y[train])
            gains.append(1.0 - np.mean((y[test] - model.predict(x[test])) ** 2) / np.var(y[test]))
            if np.mean(gains) > 0:
                shuffled = permutation_importance(model, x[test], y[test], n_repeats=1, random_state=seed)
                importance += shuffled.importances_mean
        if np.mean(gains) > _MIN_R2 and np.mean(gains) > 4 * np.std(gains) / np.sqrt(_FOLDS) and np.min(gains) > 0:
            top = int(importance.argmax())
            out.append({"axis": axis + 1, "variable": names[top], "share": float(np.mean(gains))})
    return out


def drivers(d) -> list[dict]:
    """For the report: what stays unexplained first, then what each effect follows; shares of the held-out variance."""
    scale = np.sum(d.after[d.is_test] ** 2) / max(np.sum(d.before[d.is_test] ** 2), 1e-300)
    out = []
    for entry in sorted(d.fit.corrections, key=lambda e: -d.shares[e.key]):
        for name in _ordered(d, entry):
            out.append({"axis": entry.term.source.axis + 1, "variable": name, "share": d.shares[entry.key]})
    out += [{**item, "share": item["share"] * scale} for item in d.left]
    for entry in d.fit.effects:
        out += _of_effect(d, entry)
    return [item for item in out if item["share"] >= _MIN_SHARE]


def _ordered(d, entry) -> list[str]:
    """Variables of a correction, the one that its force varies with most first."""
    names = list(entry.term.source.variables)
    force = entry.force(d.data)[:, entry.term.source.axis]
    return sorted(names, key=lambda name: -_explained(variable(d.data, name), force))


def _of_effect(d, entry) -> list[dict]:
    force = entry.force(d.data)[d.is_test]
    total = max(np.sum(d.before[d.is_test] ** 2), 1e-300)
    stem = entry.term.source.follows
    if not stem:
        return []
    by_time = "temp" if d.data.temp_c is not None and np.ptp(d.data.temp_c) > 0 else "t"
    return [
        {"axis": int(axis) + 1, "variable": by_time if stem == "t" else f"{stem}{axis + 1}",
         "share": min(float(np.sum(force[:, axis] ** 2) / total), 1.0)}
        for axis in np.flatnonzero(np.any(force, axis=0))
    ]  # fmt: skip


def _explained(x: np.ndarray, y: np.ndarray, n_bins: int = 30) -> float:
    """Correlation ratio: variance of y between quantile bins of x."""
    edges = np.unique(np.quantile(x, np.linspace(0, 1, n_bins + 1)[1:-1]))
    bins = np.searchsorted(edges, x)
    count = np.bincount(bins, minlength=len(edges) + 1)
    mean = np.bincount(bins, y, len(edges) + 1) / np.maximum(count, 1)
    return float((count * (mean - y.mean()) ** 2).sum() - count.astype(bool).sum() * y.var())
