"""What is left after the fit: does it follow any measured variable, and which?"""

import numpy as np
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.inspection import permutation_importance

from gravcomp.diagnosis.candidate import variables
from gravcomp.diagnosis.fit import Fit
from gravcomp.diagnosis.samples.split import folds
from gravcomp.diagnosis.shares import along
from gravcomp.diagnosis.thresholds import FOLDS, LEFT_R2, LEFT_SAMPLES, LEFT_SAMPLES_USED, LEFT_SHARE, TINY


def find(data, after, rows, blocks, noise, seed: int) -> list[dict]:
    """Drivers of structure that neither effects nor corrections took: axis, variable, share of what is left.

    Random trees over all variables, cross-validated by blocks; it counts when they predict more than 5 % of the
    variance on average, some in every fold, and the mean is four standard errors above zero.
    """
    if unavailable(data, rows, blocks):
        return []
    rows = _used(data, rows)
    names, parts = variables(data), folds(blocks[rows])
    x = np.column_stack([name.of(data)[rows] for name in names])
    out = []
    for axis in range(data.n_axes):
        y = np.clip(after[rows, axis], -4 * noise[axis], 4 * noise[axis])
        gains, importance = [], np.zeros(len(names))
        for train, test in parts:
            model = ExtraTreesRegressor(40, min_samples_leaf=10, random_state=seed).fit(x[train], y[train])
            gains.append(1.0 - np.mean((y[test] - model.predict(x[test])) ** 2) / np.var(y[test]))
            if gains[-1] <= 0:
                break
            shuffled = permutation_importance(model, x[test], y[test], n_repeats=1, random_state=seed)
            importance += shuffled.importances_mean
        if np.min(gains) > 0 and np.mean(gains) > max(LEFT_R2, 4 * np.std(gains) / np.sqrt(FOLDS)):
            top = int(importance.argmax())
            out.append({"axis": axis + 1, "variable": names[top], "share": float(np.mean(gains))})
    return out


def unavailable(data, rows, blocks) -> str:
    """Why what is left in these rows can't be looked at for structure; "" where it can."""
    rows = _used(data, rows)
    if len(rows) < LEFT_SAMPLES:
        return f"{len(rows)} samples to train on, {LEFT_SAMPLES} are needed"
    if not folds(blocks[rows]):
        return f"the samples to train on are from fewer than {FOLDS} stretches of time or clusters of poses"
    return ""


def _used(data, rows) -> np.ndarray:
    """Rows without an undecided effort; of very many those at equal distances."""
    rows = rows[~data.is_undecided[rows].any(axis=1)]
    return rows[np.linspace(0, len(rows) - 1, min(len(rows), LEFT_SAMPLES_USED)).astype(int)]


def drivers(data, use, before, after, fit: Fit, left) -> list[dict]:
    """For the report: what stays unexplained first, then what each effect follows; parts of the square sum before.

    use (n, k): held-out samples; before, after (n, k) residuals; left as ``find`` gives it. Parts are those of
    ``shares.along``: of terms that overlap each has what it brings beside the others. "of" is the effect that a row
    belongs to, "" where it has no name; no row stands there twice.
    """
    total = max(np.sum(before[use] ** 2), TINY)
    parts = {id(entry): along(data, entry, use, before) / total for entry in fit.entries}
    out = []
    for entry in fit.corrections:
        for axis, variable in entry.term.candidate.follows(data, entry.parameters, data.once(entry.force)):
            out.append(_item(axis, variable, parts[id(entry)][axis]))
    out.sort(key=lambda item: -item["share"])
    out += [{**item, "share": item["share"] * np.sum(after[use] ** 2) / total, "of": ""} for item in left]
    for entry in fit.effects:
        for axis, variable in entry.term.candidate.follows(data, entry.parameters, data.once(entry.force)):
            out.append(_item(axis, variable, parts[id(entry)][axis], entry.name))
    once: dict[tuple, dict] = {}
    for item in out:
        once.setdefault((item["of"], item["axis"], item["variable"]), item)
    return [item for item in once.values() if abs(item["share"]) >= LEFT_SHARE]


def _item(axis: int, variable: str, share: float, of: str = "") -> dict:
    return {"axis": axis + 1, "variable": variable, "share": float(share), "of": of}
