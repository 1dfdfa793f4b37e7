"""Exact fit of chosen terms: effects by their own equations, corrections linearly; Huber weights by outer turns."""

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from gravcomp.diagnosis.search import Term
from gravcomp.logs.measurement import Measurement

_HUBER = 2.5
_TURNS = 2


@dataclass
class Entry:
    """One fitted term: parameters by name, 95 % intervals, p-value of the whole."""

    term: Term
    parameters: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    p_value: float

    @property
    def name(self) -> str:
        return self.term.name

    @property
    def key(self) -> str:
        return self.term.name

    def force(self, data: Measurement) -> np.ndarray:
        """Predicted force (n, k)."""
        if self.term.is_physical:
            return self.term.source.predict(data, self.parameters)
        force = np.zeros(data.shape)
        force[:, self.term.source.axis] = self.term.source.columns(data) @ np.array(list(self.parameters.values()))
        return force


@dataclass
class Fit:
    effects: list[Entry]
    corrections: list[Entry]

    @property
    def n_parameters(self) -> int:
        return sum(len(entry.parameters) for entry in self.effects + self.corrections)

    def predict(self, data: Measurement) -> np.ndarray:
        return sum((entry.force(data) for entry in self.effects + self.corrections), np.zeros(data.shape))


def fit_terms(data: Measurement, residual: np.ndarray, rows: np.ndarray, terms: list[Term], noise: np.ndarray) -> Fit:
    """Fit all terms together on the given rows; noise (k,) weighs the axes."""
    if not terms:
        return Fit([], [])
    y, scale = residual[rows], np.maximum(noise, 1e-300)
    sure = (~data.is_undecided[rows]).astype(float)
    weight = sure
    start = _linear_start(data, y, rows, terms, sure / scale)
    for _ in range(_TURNS):
        values, jacobian, left = _solve(data, y, rows, terms, start, np.sqrt(weight) / scale)
        spread = 1.4826 * np.median(np.abs(left), axis=0) + 1e-300
        weight = sure * np.minimum(1.0, _HUBER * spread / np.maximum(np.abs(left), 1e-300))
        start = values
    return _entries(terms, values, jacobian, left / scale * np.sqrt(weight))


def _linear_start(data, y, rows, terms, weight) -> list[dict[str, float]]:
    """Coefficients of the linearised terms, turned into parameters."""
    blocks = []
    for term in terms:
        if term.is_physical:
            columns = term.source.columns(data, term.shape)
            blocks.append(np.stack([(columns[label][rows] * weight).ravel() for label in term.labels], axis=-1))
        else:
            full = np.zeros((*y.shape, len(term.labels)))
            axis = term.source.axis
            full[:, axis] = term.source.columns(data)[rows] * weight[:, [axis]]
            blocks.append(full.reshape(-1, len(term.labels)))
    x = np.hstack(blocks)
    norm = np.linalg.norm(x, axis=0) + 1e-300
    theta = np.linalg.lstsq(x / norm, (y * weight).ravel(), rcond=1e-9)[0] / norm
    out, at = [], 0
    for term in terms:
        own = dict(zip(term.labels, theta[at : at + len(term.labels)].tolist(), strict=True))
        at += len(term.labels)
        out.append(_parameters(term, own))
    return out


def _parameters(term: Term, coefficients: dict[str, float]) -> dict[str, float]:
    if not term.is_physical:
        return coefficients
    axes = {label.rsplit("_", 1)[-1] for label in term.labels}
    shape = {name: value for name, value in term.shape.items()
             if not name[-1].isdigit() or name.rsplit("_", 1)[-1] in axes}  # fmt: skip
    found = term.source.parameters(shape, coefficients)
    return {name: value for name, value in found.items() if isinstance(value, float)}


def _solve(data, y, rows, terms, start, weight):
    """Least squares over the effects' parameters, corrections projected out; returns values, Jacobian, residual."""
    names = [(k, name) for k, term in enumerate(terms) if term.is_physical for name in start[k]]
    x0 = np.array([start[k][name] for k, name in names])
    size = np.maximum(np.abs(x0), 1e-9)
    positive = [_positive(term) for term in terms]
    columns = {k: term.source.columns(data)[rows] for k, term in enumerate(terms) if not term.is_physical}
    basis = _basis(y.shape, [terms[k].source.axis for k in columns], list(columns.values()), weight)
    q = np.linalg.svd(basis, full_matrices=False)[0][:, : np.linalg.matrix_rank(basis)] if columns else basis

    def physical(x):
        force = np.zeros(data.shape)
        for k, term in enumerate(terms):
            if term.is_physical:
                own = {name: x[j] for j, (m, name) in enumerate(names) if m == k}
                force = force + term.source.predict(data, own)
        return force[rows]

    def error(scaled):
        e = ((y - physical(scaled * size)) * weight).ravel()
        return e - q @ (q.T @ e)

    x, jacobian = x0, np.zeros((y.size, 0))
    if names:
        low = [0.0 if name in positive[k] else -np.inf for k, name in names]
        found = least_squares(error, np.maximum(x0 / size, low), bounds=(low, np.inf), x_scale="jac", max_nfev=12)
        x, jacobian = found.x * size, found.jac / size
    left = y - (physical(x) if names else 0.0)
    theta = np.linalg.lstsq(basis, (left * weight).ravel(), rcond=1e-9)[0] if columns else np.zeros(0)
    values, at = [], 0
    for k, term in enumerate(terms):
        if term.is_physical:
            values.append({name: float(x[j]) for j, (m, name) in enumerate(names) if m == k})
        else:
            values.append(dict(zip(term.labels, theta[at : at + len(term.labels)].tolist(), strict=True)))
            at += len(term.labels)
    if columns:
        fitted = np.zeros_like(y)
        for k, own in columns.items():
            fitted[:, terms[k].source.axis] += own @ np.array(list(values[k].values()))
        left = left - fitted
    return values, (names, x, jacobian), left


def _basis(shape, axes, columns, weight) -> np.ndarray:
    """Columns (n, m) of each correction, weighted, as forces of all axes one below the other (n k, sum of m)."""
    basis = np.zeros((*shape, sum(own.shape[1] for own in columns)))
    at = 0
    for axis, own in zip(axes, columns, strict=True):
        basis[:, axis, at : at + own.shape[1]] = own * weight[:, [axis]]
        at += own.shape[1]
    return basis.reshape(shape[0] * shape[1], basis.shape[-1])


def _positive(term: Term) -> set[str]:
    """Parameters that physics makes positive."""
    contrasts = term.source.contrasts(list(term.labels)) if term.is_physical else []
    return {label for contrast in contrasts if len(contrast) == 1 for label in contrast}


def _entries(terms, values, solution, normed) -> Fit:
    """Intervals from the Jacobian, widened for autocorrelated noise."""
    names, x, jacobian = solution
    freedom = max(normed.size - jacobian.shape[1], 1)
    variance = np.sum(normed**2) / freedom * _correlation(normed)
    norm = np.linalg.norm(jacobian, axis=0) + 1e-300
    covariance = np.linalg.pinv((jacobian / norm).T @ (jacobian / norm), rcond=1e-10) / norm[:, None] / norm * variance
    half = stats.t.ppf(0.975, freedom) * np.sqrt(np.maximum(np.diag(covariance), 0.0)) if len(x) else x
    effects, corrections = [], []
    for k, term in enumerate(terms):
        own = [j for j, (m, _) in enumerate(names) if m == k]
        intervals = {names[j][1]: (float(x[j] - half[j]), float(x[j] + half[j])) for j in own}
        entry = Entry(term, values[k], intervals, _p_value(x[own], covariance[np.ix_(own, own)]) if own else 0.0)
        (effects if term.is_physical else corrections).append(entry)
    return Fit(effects, corrections)


def _p_value(x, covariance) -> float:
    """Wald test that all parameters of an effect are zero."""
    error = np.sqrt(np.maximum(np.diag(covariance), 1e-200))  # data without noise have none
    z, correlation = x / error, covariance / np.outer(error, error)
    np.fill_diagonal(correlation, 1.0)
    return float(stats.chi2.sf(z @ np.linalg.pinv(correlation, rcond=1e-10) @ z, len(x)))


def _correlation(normed: np.ndarray) -> float:
    r = np.clip(normed, -3, 3)
    lag = np.sum(r[1:] * r[:-1]) / max(np.sum(r * r), 1e-300)
    return float((1 + max(lag, 0.0)) / (1 - min(max(lag, 0.0), 0.95)))
