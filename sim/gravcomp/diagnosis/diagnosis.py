"""From measured data to the effects that the model lacks.

1. Terms: every effect of the vocabulary that the data can show, every empirical correction.
2. Search on the training blocks, three rounds: each re-estimates outliers, noise per axis, independent samples, and
   the periodic lines of what is left.
3. Exact fit of the chosen effects, on the training blocks; errors on held-out blocks that no fit has seen.
"""

from dataclasses import dataclass, field

import numpy as np
from threadpoolctl import threadpool_limits

from gravcomp.diagnosis import leftover, periodogram, split
from gravcomp.diagnosis.corrections import Correction, candidates
from gravcomp.diagnosis.effects import EFFECTS
from gravcomp.diagnosis.effects.cogging import Cogging
from gravcomp.diagnosis.fit import Fit, fit_terms
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.search import Evidence, Term
from gravcomp.logs.measurement import Measurement

_ROUNDS = 3
_SEARCH_SAMPLES = 5000
_HUBER = 2.5
_MINOR_SHARE = 0.03  # of what was explained: a correction this small does not spoil an explanation


@dataclass
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
    left: list[dict] = field(default_factory=list)

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
    rows = train[np.linspace(0, len(train) - 1, min(len(train), _SEARCH_SAMPLES)).astype(int)]
    tick("effects")
    pool, untestable = _terms(data, rows)
    chosen, evidence, members, noise = _search(data, before, rows, pool, tick)
    tick("fit")
    if evidence.is_physics_whole:
        fit = fit_terms(data, before, train, [term for term in chosen if term.is_physical], noise)
        after = before - fit.predict(data)
        fit.corrections += fit_terms(data, after, train, [t for t in chosen if not t.is_physical], noise).corrections
        after = before - fit.predict(data)
    else:
        fit = fit_terms(data, before, train, chosen, noise)
        after = before - fit.predict(data)
    left = leftover.find(data, after, rows, blocks, noise, seed)
    tick("report")
    physical = {entry.name for entry in fit.effects}
    sets = [names for names in evidence.alternatives(members) if names[0] in physical]
    result = Diagnosis(
        data, is_test, blocks, before, after, fit, "", sets + _identities(fit), [], {},
        np.sqrt(_noise_variance(data, after, train, fit)), untestable, left,
    )  # fmt: skip
    result.shares = _shares(result)
    result.verdict = _verdict(result)
    result.drivers = leftover.drivers(result)
    return result


def _terms(data: Measurement, rows: np.ndarray) -> tuple[list[tuple[Term, list]], dict[str, str]]:
    pool, untestable = [], {}
    for kind in EFFECTS:
        effect = kind()
        why = effect.unavailable(data)
        if why:
            untestable[effect.name] = why
            continue
        pool += [_effect_term(data, rows, effect, shape) for shape in effect.shapes(data)]
    pool += [_correction_term(data, rows, correction) for correction in candidates(data)]
    return [entry for entry in pool if any(column is not None for column in entry[1])], untestable


def _effect_term(data, rows, effect, shape) -> tuple[Term, list]:
    columns = effect.columns(data, shape)
    stacked = np.stack([column[rows] for column in columns.values()], axis=-1)
    by_axis = [stacked[:, i] if np.any(stacked[:, i]) else None for i in range(data.n_axes)]
    return Term(effect, tuple(columns), shape), by_axis


def _correction_term(data, rows, correction: Correction) -> tuple[Term, list]:
    columns = correction.columns(data)[rows]
    by_axis = [columns if i == correction.axis else None for i in range(data.n_axes)]
    return Term(correction, tuple(f"value_{k}" for k in range(columns.shape[1]))), by_axis


def _search(data, before, rows, pool, tick):
    residual, sure = before[rows], (~data.is_undecided[rows]).astype(float)
    weight = sure
    variance = np.maximum(residual.var(axis=0), 1e-300)
    independent = sure.sum(axis=0)
    unexplained, ripples = residual, [residual]
    for turn in range(_ROUNDS):
        tick(f"search {turn + 1}")
        periodic = _periodic_terms(data, rows, ripples, unexplained)
        entries = pool + periodic
        evidence = Evidence([term for term, _ in entries], [c for _, c in entries], residual, weight, variance,
                            independent)  # fmt: skip
        members = evidence.prune(evidence.pick())
        fitted = {k: _fitted(evidence, members, entries, k, rows) for k in members}
        unexplained = residual - sum(fitted.values(), np.zeros_like(residual))
        ripple = [f for k, f in fitted.items() if _is_periodic(evidence.terms[k])]
        smooth = [f for k, f in fitted.items() if evidence.terms[k].is_physical and not _is_periodic(evidence.terms[k])]
        # beside the corrections, and without them: tables may have swallowed a ripple
        ripples = [unexplained + sum(ripple, np.zeros_like(residual)), residual - sum(smooth, np.zeros_like(residual))]
        spread = 1.4826 * np.median(np.abs(unexplained - np.median(unexplained, axis=0)), axis=0)
        spread = np.maximum(spread, 1e-9 * np.abs(data.force).max())
        weight = sure * np.minimum(1.0, _HUBER * spread / np.maximum(np.abs(unexplained), 1e-300))
        variance = (weight * unexplained**2).sum(axis=0) / weight.sum(axis=0)
        variance = np.maximum(variance, spread**2 * 1e-6)
        independent = sure.sum(axis=0) / _correlation_length(unexplained)
    chosen = [evidence.terms[k] for k in sorted(members)]
    return chosen, evidence, members, np.sqrt(variance)


def _fitted(evidence: Evidence, members, entries, k, rows) -> np.ndarray:
    index, theta, _, _ = evidence.solve(members)
    value = dict(zip(index, theta, strict=True))
    origin = next(j for j, (term, _) in enumerate(entries) if set(evidence.place[k]) <= set(evidence.place[j]))
    weights = np.array([value.get(column, 0.0) if column in set(evidence.place[k]) else 0.0
                        for column in evidence.place[origin]])  # fmt: skip
    columns = entries[origin][1]
    return np.column_stack([np.zeros(len(rows)) if c is None else c @ weights for c in columns])


def _is_periodic(term: Term) -> bool:
    return isinstance(term.source, Cogging) or (not term.is_physical and term.source.kind == "wave")


def _periodic_terms(data, rows, ripples, unexplained) -> list[tuple[Term, list]]:
    """Cogging at the pitches that lines in the residuals propose; waves and steps in time."""
    scaled = [residual / np.maximum(residual.std(axis=0), 1e-300) for residual in ripples]
    pitches = set().union(*(_pitches(data, rows, residual) for residual in scaled))
    out = []
    for pitch, harmonics in sorted(pitches):
        out.append(_effect_term(data, rows, Cogging(), {"pitch": pitch, "harmonics": harmonics}))
    for i in range(data.n_axes):
        when = periodogram.step_in(data.t_s[rows], unexplained[:, i])
        out.append(_correction_term(data, rows, Correction(i, "step", ("t",), (when,))))
        for frequency, _ in periodogram.find_lines(data.t_s[rows], scaled[0][:, [i]], 2):
            out.append(_correction_term(data, rows, Correction(i, "wave", ("t",), (frequency,))))
    return out


def _pitches(data, rows, scaled) -> set[tuple[float, tuple[int, ...]]]:
    """Pitch and harmonics that all axes together, and each alone, show over their positions; the strongest line as the
    fundamental, and as a harmonic of a longer pitch.
    """
    q = data.q[rows]
    span = np.ptp(q, axis=0).max()
    turn = 2.0 * np.pi if data.position_units and data.position_units[0] == "rad" else None
    lines = [periodogram.find_lines(q, scaled)]
    lines += [periodogram.find_lines(q[:, [i]], scaled[:, [i]]) for i in range(data.n_axes) if data.n_axes > 1]
    found = {periodogram.pitch_of(own, span, turn, divisors) for own in lines for divisors in (1, 6)}
    return {pitch for pitch in found if pitch}


def _correlation_length(residual: np.ndarray) -> np.ndarray:
    """Samples per independent sample, per axis: 1 + 2 sum of the autocorrelation until it first drops below 0.05."""
    out = np.ones(residual.shape[1])
    for i, r in enumerate((residual - residual.mean(axis=0)).T):
        limit = 3.0 * 1.4826 * np.median(np.abs(r)) + 1e-300
        r = np.clip(r, -limit, limit)
        for lag in range(1, min(200, len(r) // 10)):
            rho = r[lag:] @ r[:-lag] / max(r @ r, 1e-300)
            if rho < max(0.05, 2.0 / np.sqrt(len(r))):
                break
            out[i] += 2.0 * rho
    return out


def _identities(fit: Fit) -> list[list[str]]:
    """Equations that are the same on any data."""
    sets = []
    for entry in fit.effects:
        if entry.name == "coulomb_friction" and any(p.startswith("fc_pos") for p in entry.parameters):
            sets.append(["coulomb_friction", "current_offset"])
        if entry.name == "cable_spring":
            sets.append(["cable_spring", "current_offset"])
    return sets


def _noise_variance(data: Measurement, after, train, fit: Fit) -> np.ndarray:
    sure = ~data.is_undecided[train]
    freedom = np.maximum(sure.sum(axis=0) - fit.n_parameters / after.shape[1], 1.0)
    return (after[train] ** 2 * sure).sum(axis=0) / freedom


def _shares(d: Diagnosis) -> dict[str, float]:
    """Part of the held-out residual's variance that goes with each entry of the fit."""
    total = max(np.sum(d.before[d.is_test] ** 2), 1e-300)
    return {
        entry.key: float(np.clip((np.sum((d.after + entry.force(d.data))[d.is_test] ** 2)
                                  - np.sum(d.after[d.is_test] ** 2)) / total, 0.0, 1.0))
        for entry in d.fit.effects + d.fit.corrections
    }  # fmt: skip


def _verdict(d: Diagnosis) -> str:
    known = sum(d.shares[entry.key] for entry in d.fit.effects)
    other = sum(d.shares[entry.key] for entry in d.fit.corrections)
    if not d.fit.effects:
        return "unexplained" if d.fit.corrections or d.left else "nothing_missing"
    if d.left or other > _MINOR_SHARE * (known + other):
        return "partly_explained"
    return "explained"
