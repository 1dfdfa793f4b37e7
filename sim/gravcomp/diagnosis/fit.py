"""Exact fit of chosen terms: effects by their own equations, corrections linearly; Huber weights by outer turns.

A correction has a prior, an effect has none: each of its columns accounts for no more than all that is to be explained.
Where a table could carry what an effect could carry as well, or the two could cancel each other, the effect has it; a
correction that the data decide is off by a part in the squared signal-to-noise ratio of the log.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from gravcomp.diagnosis.candidate import Parameter, Term
from gravcomp.diagnosis.thresholds import HUBER, HUBER_TURNS, MAD_TO_SIGMA, PULL, RIDGE_LEAST, TINY
from gravcomp.logs.measurement import Measurement


@dataclass(frozen=True)
class Entry:
    """One fitted term: parameters by name, 95 % intervals (of effects), p-value of the whole."""

    term: Term
    parameters: Mapping[Parameter, float]
    intervals: Mapping[Parameter, tuple[float, float]]
    p_value: float

    @property
    def name(self) -> str:
        return self.term.name

    def force(self, data: Measurement) -> np.ndarray:
        """Predicted force (n, k)."""
        return self.term.candidate.predict(data, self.parameters)


@dataclass(frozen=True)
class Fit:
    effects: tuple[Entry, ...] = ()
    corrections: tuple[Entry, ...] = ()

    @property
    def entries(self) -> tuple[Entry, ...]:
        return self.effects + self.corrections

    @property
    def n_parameters(self) -> int:
        return sum(len(entry.parameters) for entry in self.entries)

    def predict(self, data: Measurement) -> np.ndarray:
        return sum((entry.force(data) for entry in self.entries), np.zeros(data.shape))


def fit_terms(
    data: Measurement,
    residual: np.ndarray,
    rows: np.ndarray,
    effects: list[Term],
    corrections: list[Term],
    noise: np.ndarray,
    left_out: np.ndarray | None = None,
    known: Mapping[str, Mapping[str, float]] = MappingProxyType({}),
    beside: np.ndarray | float = 0.0,
) -> Fit:
    """Fit all terms together on the given rows; noise (k,) weighs the axes; left_out (rows, k) has no weight; known:
    parameters that the model has already, of which a change may take away; beside (n, k): a force that is not fitted
    here, and that makes no sample an outlier.
    """
    if not effects and not corrections:
        return Fit()
    y, scale = residual[rows], np.maximum(noise, TINY)
    sure = (~data.is_undecided[rows]).astype(float)
    sure = sure if left_out is None else sure * ~left_out
    weight, beside = sure, np.broadcast_to(beside, residual.shape)[rows]
    start = _linear_start(data, y, rows, effects, corrections, sure / scale)
    fixed = [term.columns(data)[rows] for term in corrections]
    for _ in range(HUBER_TURNS):
        solution = _solve(data, y, rows, effects, fixed, start, np.sqrt(weight) / scale, known)
        size = np.abs(solution.left - beside)
        spread = MAD_TO_SIGMA * np.median(size, axis=0) + TINY
        weight = sure * np.minimum(1.0, HUBER * spread / np.maximum(size, TINY))
        start = solution.values
    return _entries(effects, corrections, solution, solution.left / scale * np.sqrt(weight))


def _linear_start(data, y, rows, effects, corrections, weight) -> list[dict[Parameter, float]]:
    """Coefficients of the linearised terms, turned into parameters of the effects."""
    blocks = [term.columns(data)[rows] * weight[..., None] for term in [*effects, *corrections]]
    x = np.concatenate(blocks, axis=-1).reshape(y.size, -1)
    norm, goal = _sizes(x), (y * weight).ravel()
    n_free = sum(len(term.labels) for term in effects)
    ridge = _ridge(goal) * np.eye(x.shape[1])[n_free:]
    padded = np.append(goal, np.zeros(len(ridge)))
    theta = np.linalg.lstsq(np.vstack([x / norm, ridge]), padded, rcond=1e-9)[0] / norm
    out, at = [], 0
    for term in effects:
        own = dict(zip(term.labels, theta[at : at + len(term.labels)].tolist(), strict=True))
        at += len(term.labels)
        out.append(_parameters(term, own))
    return out


def _sizes(x: np.ndarray) -> np.ndarray:
    """Norms of columns; of one that moves nothing, as a moment on slides, 1 and no rounding over nothing."""
    norm = np.linalg.norm(x, axis=0)
    return np.where(norm < TINY, 1.0, norm)


def _ridge(goal: np.ndarray) -> float:
    """1/|goal|, for columns of size one: the prior of a coefficient is zero to within all that is to be explained, in
    units of its noise. Data without noise leave it a size that rounding does not reach.
    """
    return max(1.0 / max(float(np.linalg.norm(goal)), 1.0), RIDGE_LEAST)


class _Taken:
    """What corrections take of errors: ridge regression on columns (m, p), of which the effects' search sees the rest.

    min over theta of |e - X theta|^2 + ridge^2 |norm theta|^2 is |rest(e)|^2, with X / norm = U diag(s) V':
    rest(e) = e - U diag(1 - ridge/sqrt(s^2 + ridge^2)) U' e.
    """

    def __init__(self, columns: np.ndarray, ridge: float):
        self._norm, self._ridge = _sizes(columns), ridge
        self._u, self._s, self._v = np.linalg.svd(columns / self._norm, full_matrices=False)
        self._part = 1.0 - ridge / np.hypot(self._s, ridge)

    def rest(self, e: np.ndarray) -> np.ndarray:
        return e - (self._u * self._part) @ (self._u.T @ e)

    def coefficients(self, e: np.ndarray) -> np.ndarray:
        return (self._v.T * (self._s / (self._s**2 + self._ridge**2))) @ (self._u.T @ e) / self._norm


def _parameters(term: Term, coefficients: dict[Parameter, float]) -> dict[Parameter, float]:
    axes = {label.axis for label in term.labels}
    shape = {name: value for name, value in term.shape.items() if getattr(name, "axis", None) in axes | {None}}
    found = term.candidate.parameters(shape, coefficients)
    return {name: float(value) for name, value in found.items() if isinstance(value, float)}


@dataclass(frozen=True)
class _Solution:
    """Parameters of each effect, coefficients of each correction; their names, values and Jacobian; residual (m, k)."""

    values: list[dict[Parameter, float]]
    coefficients: list[np.ndarray]
    names: list[tuple[int, Parameter]]
    x: np.ndarray
    jacobian: np.ndarray
    left: np.ndarray


def _solve(data, y, rows, effects, fixed, start, weight, known) -> _Solution:
    """Least squares over the effects' parameters, with what corrections take of each error taken off.

    What moves nothing stays at its start, of the smallest norm: a faint pull to it decides where the data do not.
    """
    names = [(k, name) for k in range(len(effects)) for name in start[k]]
    x0 = np.array([start[k][name] for k, name in names])
    size = np.maximum(np.abs(x0), 1e-9)
    low, high, mix = _bounds(effects, names, x0, known)
    basis = np.concatenate([np.zeros((*y.shape, 0)), *fixed], axis=-1)
    weighted = (basis * weight[..., None]).reshape(y.size, -1)
    taken = _Taken(weighted, _ridge((y * weight).ravel()))
    force = _Physics(data, rows, effects, names)

    def moved(scaled):
        """Weighted derivatives (m k, p) of the force."""
        return (force.jacobian(mix @ (scaled * size)) * weight[..., None]).reshape(y.size, -1) @ mix * size

    def error(scaled):
        own = taken.rest(((y - force(mix @ (scaled * size))) * weight).ravel())
        return np.concatenate([own, pull * (scaled - first)])

    def slope(scaled):
        return np.vstack([-taken.rest(moved(scaled)), np.diag(pull)])

    x, jacobian = x0, np.zeros((y.size, 0))
    if names:
        first = np.clip(np.linalg.solve(mix, x0), low, high) / size
        pull = PULL * np.linalg.norm(moved(first), axis=0)
        bounds = (low / size, high / size)
        found = least_squares(error, first, jac=slope, bounds=bounds, x_scale="jac", max_nfev=12)
        x, jacobian = mix @ (found.x * size), found.jac[: y.size] / size @ np.linalg.inv(mix)
    left = y - force(x)
    theta = taken.coefficients((left * weight).ravel())
    ends = np.cumsum([columns.shape[-1] for columns in fixed])[:-1] if fixed else []
    values = [force.parameters(x, k) for k in range(len(effects))]
    return _Solution(values, np.split(theta, ends), names, x, jacobian, left - basis @ theta)


class _Physics:
    """Force (m, k) of the effects on some rows, and its derivatives: columns of linear effects are computed once."""

    def __init__(self, data, rows, effects: list[Term], names: list[tuple[int, Parameter]]):
        self._data, self._rows, self._effects, self._names = data, rows, effects, names
        self._own = [[j for j, (m, _) in enumerate(names) if m == k] for k in range(len(effects))]
        self._fixed = [self._columns(k) for k in range(len(effects))]

    def parameters(self, x: np.ndarray, k: int) -> dict[Parameter, float]:
        return {self._names[j][1]: float(x[j]) for j in self._own[k]}

    def __call__(self, x: np.ndarray) -> np.ndarray:
        total = np.zeros((len(self._rows), self._data.n_axes))
        for k, term in enumerate(self._effects):
            if self._fixed[k] is not None:
                total += self._fixed[k] @ x[self._own[k]]
            else:
                total += term.candidate.predict(self._data, self.parameters(x, k))[self._rows]
        return total

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """(m, k, parameters)."""
        out = np.empty((len(self._rows), self._data.n_axes, len(self._names)))
        for k, term in enumerate(self._effects):
            if self._fixed[k] is not None:
                out[..., self._own[k]] = self._fixed[k]
            else:
                by_name = term.candidate.jacobian(self._data, self.parameters(x, k))
                for j in self._own[k]:
                    out[..., j] = by_name[self._names[j][1]][self._rows]
        return out

    def _columns(self, k: int) -> np.ndarray | None:
        """(m, k, parameters) of a linear effect, None of another."""
        term, names = self._effects[k], [self._names[j][1] for j in self._own[k]]
        if not term.candidate.is_linear:
            return None
        columns = term.candidate.columns(self._data, term.shape)
        if not all(name in columns for name in names):
            return None
        return np.stack([columns[name][self._rows] for name in names], axis=-1)


def _bounds(effects, names, x0, known) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bounds of the variables z of the search, and mix, with parameters x = mix z.

    z is x itself; where a difference of two parameters, with that of the model, is >= 0, it is the difference.
    """
    low, high, mix = np.full(len(x0), -np.inf), np.full(len(x0), np.inf), np.eye(len(x0))
    place = {own: j for j, own in enumerate(names)}
    for j, (k, name) in enumerate(names):
        candidate = effects[k].candidate
        if getattr(name, "stem", name) in candidate.scales:
            low[j] = 1e-6 * abs(x0[j])
        low[j], high[j] = max(low[j], -effects[k].limit(name)), effects[k].limit(name)
    for k, term in enumerate(effects):
        for contrast in term.candidate.contrasts(term.labels):
            own = [(place[k, label], factor, label) for label, factor in contrast.items() if (k, label) in place]
            if len(own) == len(contrast) == 1:
                j, factor, label = own[0]
                (low if factor > 0 else high)[j] = -np.sign(factor) * term.candidate.allowance(label, known)
            elif len(own) == len(contrast) == 2:
                (a, _, _), (b, _, _) = sorted(own, key=lambda entry: -entry[1])
                allowed = sum(factor * term.candidate.allowance(label, known) for _, factor, label in own)
                mix[a, b], low[a] = 1.0, -max(allowed, 0.0)
    return low, high, mix


def _entries(effects, corrections, found: _Solution, normed) -> Fit:
    """Intervals from the Jacobian, widened for autocorrelated noise."""
    x, jacobian = found.x, found.jacobian
    freedom = max(normed.size - jacobian.shape[1], 1)
    variance = np.sum(normed**2) / freedom * _correlation(normed)
    norm = np.linalg.norm(jacobian, axis=0)
    norm[norm == 0.0] = 1.0  # a parameter that moves nothing, as the phase of a wave of size zero
    covariance = np.linalg.pinv((jacobian / norm).T @ (jacobian / norm), rcond=1e-10) / norm[:, None] / norm * variance
    half = stats.t.ppf(0.975, freedom) * np.sqrt(np.maximum(np.diag(covariance), 0.0)) if len(x) else x
    named = []
    for k, term in enumerate(effects):
        own = [j for j, (m, _) in enumerate(found.names) if m == k]
        intervals = {found.names[j][1]: (float(x[j] - half[j]), float(x[j] + half[j])) for j in own}
        named.append(Entry(term, found.values[k], intervals, _p_value(x[own], covariance[np.ix_(own, own)])))
    plain = [
        Entry(term, dict(zip(term.labels, values.tolist(), strict=True)), {}, 0.0)
        for term, values in zip(corrections, found.coefficients, strict=False)
    ]
    return Fit(tuple(named), tuple(plain))


def _p_value(x, covariance) -> float:
    """Wald test that all parameters of an effect are zero."""
    error = np.sqrt(np.maximum(np.diag(covariance), 1e-200))  # data without noise have none
    z, correlation = x / error, covariance / np.outer(error, error)
    np.fill_diagonal(correlation, 1.0)
    return float(stats.chi2.sf(z @ np.linalg.pinv(correlation, rcond=1e-10) @ z, len(x)))


def _correlation(normed: np.ndarray) -> float:
    r = np.clip(normed, -3, 3)
    lag = np.sum(r[1:] * r[:-1]) / max(np.sum(r * r), TINY)
    return float((1 + max(lag, 0.0)) / (1 - min(max(lag, 0.0), 0.95)))
