"""Other tools beside the diagnosis, on the same sealed sets: what they leave where nothing was fitted, what they name.

Each tool gets the variables of the diagnosis and its training samples, one axis at a time. A set is opened after all.
"""

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import stats
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.model_selection import GroupKFold

from gravcomp.diagnosis.candidate import variables
from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.logs.measurement import Measurement
from gravcomp_lab.blind import from_model

OURS = "gravcomp diagnose"
TOOLS = (OURS, "least squares, all friction terms", "PySINDy, STLSQ", "random trees")
_SIGNIFICANT = 1e-3  # p of a t test, for each of some twenty terms
# Of STLSQ, on standardised terms: ridge, and threshold in standard deviations of what is sought; chosen by
# cross-validation, as no one pair suits holds and motions.
_SETTINGS = tuple((alpha, threshold) for alpha in (1e-3, 0.05, 1.0, 10.0) for threshold in (0.02, 0.05, 0.1))
_FOLDS = 4
_TREES = 200


@dataclass(frozen=True)
class ToolResult:
    """Of one tool on one set: held-out RMS over the noise there, names given (None: the tool gives none), seconds."""

    kind: str
    truth: tuple[str, ...]
    over_noise: float
    named: frozenset[str] | None
    seconds: float


def run_case(kind: str, seed: int) -> dict[str, ToolResult]:
    """All tools on one set of the analytic model, by name."""
    case = from_model.draw(kind, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        began = time.process_time()
        found = diagnose(case.data, Model(), 0)
        ours = found.after, frozenset(entry.name for entry in found.fit.effects), time.process_time() - began
        train, out = ~found.is_test, {OURS: ours}
        for name, tool in zip(TOOLS[1:], (_least_squares, _sindy, _trees), strict=True):
            began = time.process_time()
            left, named = tool(case.data, train, found.blocks)
            out[name] = left, named, time.process_time() - began
    return {name: _result(case, found.is_test, *own) for name, own in out.items()}


def _result(case: from_model.Case, is_test: np.ndarray, left, named, seconds: float) -> ToolResult:
    ratio = np.sqrt(np.mean(left[is_test] ** 2) / np.mean(case.noise[is_test] ** 2))
    return ToolResult(case.kind, case.truth, float(ratio), named, seconds)


def _by_axis(data: Measurement, fit: Callable) -> tuple[np.ndarray, frozenset[str] | None]:
    """What is left (n, k), and the names of all axes, of fit(axis, residual) -> (prediction, names or None)."""
    residual = data.force - data.nominal
    found = [fit(i, residual[:, i]) for i in range(data.n_axes)]
    left = residual - np.column_stack([prediction for prediction, _ in found])
    given = [names for _, names in found if names is not None]
    return left, frozenset().union(*given) if given else None


def _least_squares(data: Measurement, train: np.ndarray, blocks: np.ndarray):
    """A textbook's identification: every friction term of the axis, offset, gain and spring, at once; t tests name."""

    def fit(i: int, y: np.ndarray):
        v, way, f = data.v[:, i], data.direction[:, i], data.nominal[:, i]
        terms = {
            "current_offset": np.ones_like(y), "coulomb_friction": way, "viscous_friction": v,
            "stribeck_friction": way * np.exp(-((v / np.quantile(np.abs(v), 0.3)) ** 2)),
            "load_dependent_friction": np.abs(f) * way, "thrust_constant": f, "cable_spring": data.q[:, i],
            "position_dependent_friction": data.q[:, i] * way,
        }  # fmt: skip
        x = np.column_stack(list(terms.values()))
        x = x / np.maximum(np.linalg.norm(x, axis=0), 1e-300) * np.sqrt(len(x))
        theta = np.linalg.lstsq(x[train], y[train], rcond=1e-9)[0]
        freedom = max(train.sum() - len(theta), 1)
        variance = np.sum((y - x @ theta)[train] ** 2) / freedom
        error = np.sqrt(np.diag(np.linalg.pinv(x[train].T @ x[train], rcond=1e-9)) * variance)
        is_named = np.abs(theta) > stats.t.isf(_SIGNIFICANT / 2, freedom) * np.maximum(error, 1e-300)
        return x @ theta, {name for name, own in zip(terms, is_named, strict=True) if own}

    return _by_axis(data, fit)


def _sindy(data: Measurement, train: np.ndarray, blocks: np.ndarray):
    """A discrepancy model: polynomials to degree 2 of the variables, sequentially thresholded least squares; the terms
    have no names of effects.
    """
    import pysindy

    x, _ = _variables(data)
    terms = np.asarray(pysindy.PolynomialLibrary(degree=2).fit_transform(x))
    rows = np.flatnonzero(train)
    folds = [(rows[a], rows[b]) for a, b in GroupKFold(_FOLDS).split(rows, groups=blocks[rows])]

    def coefficients(own, y, setting):
        alpha, threshold = setting
        return pysindy.STLSQ(threshold=threshold, alpha=alpha).fit(terms[own], y[own, None]).coef_[0]

    def fit(i: int, y: np.ndarray):
        scale = y[train].std() or 1.0
        unit = y / scale

        def error(setting):
            return sum(np.sum((unit[b] - terms[b] @ coefficients(a, unit, setting)) ** 2) for a, b in folds)

        return scale * (terms @ coefficients(rows, unit, min(_SETTINGS, key=error))), None

    return _by_axis(data, fit)


def _trees(data: Measurement, train: np.ndarray, blocks: np.ndarray):
    x, _ = _variables(data)

    def fit(i: int, y: np.ndarray):
        return ExtraTreesRegressor(_TREES, min_samples_leaf=3, random_state=0).fit(x[train], y[train]).predict(x), None

    return _by_axis(data, fit)


def _variables(data: Measurement) -> tuple[np.ndarray, list[str]]:
    """Every variable that the diagnosis looks at, standardised, (n, p)."""
    names = variables(data)
    x = np.column_stack([name.of(data) for name in names])
    return (x - x.mean(axis=0)) / x.std(axis=0), names


def table(results: list[dict[str, ToolResult]]) -> str:
    """Markdown: a row per tool."""
    lines = [
        "| tool | held out over noise: listed | pair | unlisted | sets where it leaves > 5 % less than ours | "
        "right names | wrong names | s per set |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for tool in TOOLS:
        own = [result[tool] for result in results]
        ratios = [_median(own, kind) for kind in ("listed", "pair", "unlisted")]
        better = sum(
            1.05 * result[tool].over_noise < result[OURS].over_noise for result in results if _is_known(result)
        )
        n_known = sum(_is_known(result) for result in results)
        names = ["none", "none"]
        if any(r.named is not None for r in own):
            truths = sum(len(r.truth) for r in own if r.kind in ("listed", "pair"))
            names = [f"{sum(len(r.named & set(r.truth)) for r in own)} of {truths}",
                     str(sum(len(r.named - set(r.truth)) for r in own))]  # fmt: skip
        seconds = f"{np.mean([r.seconds for r in own]):.3f}"
        lines.append(f"| {tool} | {' | '.join(ratios)} | {better} of {n_known} | {' | '.join(names)} | {seconds} |")
    return "\n".join(lines)


def _is_known(result: dict[str, ToolResult]) -> bool:
    return result[OURS].kind in ("listed", "pair", "clean")


def _median(own: list[ToolResult], kind: str) -> str:
    ratios = [r.over_noise for r in own if r.kind == kind]
    return f"{np.median(ratios):.3f}" if ratios else "-"
