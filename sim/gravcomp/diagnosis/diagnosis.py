"""From measured data to the effects that the model lacks.

1. Candidates: every effect of the vocabulary that the data can show, every empirical correction.
2. Search on the training blocks, in rounds: each re-estimates outliers, noise per axis, independent samples, and
   the periodic lines of what is left.
3. Exact fit of the chosen effects, on the training blocks; errors on held-out blocks that no fit has seen.
"""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from gravcomp.diagnosis import corrections, leftover, split, verdict
from gravcomp.diagnosis.candidate import Regressor, Term
from gravcomp.diagnosis.criterion import Criterion
from gravcomp.diagnosis.effects import EFFECTS
from gravcomp.diagnosis.fit import Fit, fit_terms
from gravcomp.diagnosis.gram import Gram
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.rules import Choice, alternatives, choose
from gravcomp.diagnosis.thresholds import HUBER, MAD_TO_SIGMA, ROUNDS, SEARCH_SAMPLES, TINY
from gravcomp.logs.measurement import Measurement


@dataclass(frozen=True)
class Diagnosis:
    """What was found: the fit, the held-out errors and the verdict. Errors (n, k) in the unit of the data."""

    data: Measurement
    is_test: np.ndarray
    blocks: np.ndarray
    before: np.ndarray
    after: np.ndarray
    fit: Fit
    verdict: str
    alternatives: list[list[str]]
    drivers: list[dict]
    shares: dict[str, float]
    noise: np.ndarray
    untestable: dict[str, str]
    left: list[dict]

    @property
    def noise_floor(self) -> float:
        return float(np.sqrt(np.mean(self.noise**2)))


@threadpool_limits.wrap(limits=1, user_api="blas")  # the matrices are small: threads only wait for one another
def diagnose(data: Measurement, model: Model, seed: int = 0, holdout: str = "blocks", progress=None) -> Diagnosis:
    """Diagnose one measurement; model brings the effects that are already known."""
    tick = progress or (lambda what: None)
    blocks = split.block_labels(data, seed)
    is_test = split.held_out(data, blocks, seed, holdout)
    before = data.force - data.nominal - model.predict(data)
    train = np.flatnonzero(~is_test)
    rows = train[np.linspace(0, len(train) - 1, min(len(train), SEARCH_SAMPLES)).astype(int)]
    tick("effects")
    found = _search(data, before, rows, tick)
    tick("fit")
    fit = _fit(data, before, train, found)
    after = before - fit.predict(data)
    left = leftover.find(data, after, rows, blocks, found.noise, seed)
    tick("report")
    share = verdict.shares(data, fit, is_test, before, after)
    return Diagnosis(
        data=data,
        is_test=is_test,
        blocks=blocks,
        before=before,
        after=after,
        fit=fit,
        verdict=verdict.verdict(fit, share, left),
        alternatives=alternatives(found.criterion, found.choice) + _identities(fit),
        drivers=leftover.drivers(data, is_test, before, after, fit, share, left),
        shares=share,
        noise=np.sqrt(_noise_variance(data, after, train, fit)),
        untestable=_untestable(data),
        left=left,
    )


@dataclass(frozen=True)
class _Found:
    """What the search ends with; noise (k,)."""

    criterion: Criterion
    choice: Choice
    noise: np.ndarray

    @property
    def effects(self) -> list[Term]:
        return [self.criterion.terms[k] for k in sorted(self.criterion.effects_of(self.choice.members))]

    @property
    def corrections(self) -> list[Term]:
        effects = self.criterion.effects_of(self.choice.members)
        return [self.criterion.terms[k] for k in sorted(self.choice.members - effects)]


def _untestable(data: Measurement) -> dict[str, str]:
    why = {kind.name: kind().unavailable(data) for kind in reversed(EFFECTS)}
    return {name: reason for name, reason in why.items() if reason}


def _effects(data: Measurement, rows: np.ndarray) -> list[Regressor]:
    able = [effect for effect in (kind() for kind in EFFECTS) if not effect.unavailable(data)]
    return [Regressor.of(effect, data, rows, shape) for effect in able for shape in effect.shapes(data)]


def _scanned_effects(data: Measurement, rows: np.ndarray, residuals: list[np.ndarray]) -> list[Regressor]:
    out = []
    for effect in (kind() for kind in EFFECTS):
        shapes = set().union(*(effect.scanned_shapes(data, rows, residual) for residual in residuals))
        out += [Regressor.of(effect, data, rows, dict(shape)) for shape in sorted(shapes)]
    return out


def _search(data: Measurement, before: np.ndarray, rows: np.ndarray, tick) -> _Found:
    residual, sure = before[rows], (~data.is_undecided[rows]).astype(float)
    effects = [entry for entry in _effects(data, rows) if entry.has_part]
    plain = [Regressor.of(correction, data, rows) for correction in corrections.candidates(data)]
    plain = [entry for entry in plain if entry.has_part]
    weight, independent = sure, sure.sum(axis=0)
    variance = np.maximum(residual.var(axis=0), TINY)
    unexplained, ripples = residual, [residual]
    for turn in range(ROUNDS):
        tick(f"search {turn + 1}")
        scaled = [ripple / np.maximum(ripple.std(axis=0), TINY) for ripple in ripples]
        in_time = corrections.scanned(data, rows, unexplained, scaled[0])
        named = effects + _scanned_effects(data, rows, scaled)
        entries = named + plain + [Regressor.of(correction, data, rows) for correction in in_time]
        gram = Gram(entries, residual, weight, variance, independent)
        criterion = Criterion([entry.term for entry in entries], gram, len(named))
        choice = choose(criterion)
        fitted = _fitted(criterion, choice, entries, residual.shape)
        nothing = np.zeros_like(residual)
        unexplained = residual - sum(fitted.values(), nothing)
        is_periodic = {k: criterion.terms[k].candidate.is_periodic for k in fitted}
        ripple = sum((force for k, force in fitted.items() if is_periodic[k]), nothing)
        smooth = sum((fitted[k] for k in criterion.effects_of(choice.members) if not is_periodic[k]), nothing)
        # beside the corrections, and without them: tables may have swallowed a ripple
        ripples = [unexplained + ripple, residual - smooth]
        spread = MAD_TO_SIGMA * np.median(np.abs(unexplained - np.median(unexplained, axis=0)), axis=0)
        spread = np.maximum(spread, 1e-9 * np.abs(data.force).max())
        weight = sure * np.minimum(1.0, HUBER * spread / np.maximum(np.abs(unexplained), TINY))
        variance = (weight * unexplained**2).sum(axis=0) / np.maximum(weight.sum(axis=0), TINY)
        variance = np.maximum(variance, spread**2 * 1e-6)
        independent = sure.sum(axis=0) / _correlation_length(unexplained)
    return _Found(criterion, choice, np.sqrt(variance))


def _fitted(criterion: Criterion, choice: Choice, entries: list[Regressor], shape) -> dict[int, np.ndarray]:
    """Force (m, k) of each term of the choice on the rows of the search."""
    out = {}
    for k, (whole, theta) in criterion.coefficients(choice.members).items():
        columns = entries[whole].by_axis
        out[k] = np.column_stack([np.zeros(shape[0]) if c is None else c @ theta for c in columns])
    return out


def _fit(data: Measurement, before: np.ndarray, train: np.ndarray, found: _Found) -> Fit:
    """Physics that is the whole story is fitted alone, corrections to what it leaves."""
    if not found.choice.is_physics_whole:
        return fit_terms(data, before, train, found.effects, found.corrections, found.noise)
    fit = fit_terms(data, before, train, found.effects, [], found.noise)
    rest = fit_terms(data, before - fit.predict(data), train, [], found.corrections, found.noise)
    return Fit(fit.effects, rest.corrections)


def _correlation_length(residual: np.ndarray) -> np.ndarray:
    """Samples per independent sample, per axis: 1 + 2 sum of the autocorrelation until it first drops below 0.05."""
    out = np.ones(residual.shape[1])
    for i, r in enumerate((residual - residual.mean(axis=0)).T):
        limit = 3.0 * MAD_TO_SIGMA * np.median(np.abs(r)) + TINY
        r = np.clip(r, -limit, limit)
        for lag in range(1, min(200, len(r) // 10)):
            rho = r[lag:] @ r[:-lag] / max(r @ r, TINY)
            if rho < max(0.05, 2.0 / np.sqrt(len(r))):
                break
            out[i] += 2.0 * rho
    return out


def _identities(fit: Fit) -> list[list[str]]:
    """Equations that are the same on any data."""
    same = [(entry.name, entry.term.candidate.same_as(entry.parameters)) for entry in fit.effects]
    return [[name, *others] for name, others in same if others]


def _noise_variance(data: Measurement, after: np.ndarray, train: np.ndarray, fit: Fit) -> np.ndarray:
    sure = ~data.is_undecided[train]
    freedom = np.maximum(sure.sum(axis=0) - fit.n_parameters / after.shape[1], 1.0)
    return (after[train] ** 2 * sure).sum(axis=0) / freedom
