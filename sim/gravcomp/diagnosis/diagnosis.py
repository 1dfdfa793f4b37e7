"""From measured data to the effects that the model lacks.

1. Candidates: every effect of the vocabulary that the data can show, every empirical correction.
2. Search on the training blocks, in rounds: each re-estimates outliers, noise per axis, independent samples, and
   the periodic lines of what is left.
3. Exact fit of the chosen effects, on the training blocks; errors on held-out blocks that no fit has seen.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from gravcomp.diagnosis import corrections, leftover, verdict
from gravcomp.diagnosis.candidate import Regressor, Term
from gravcomp.diagnosis.effects import EFFECTS, Effect, effect_named
from gravcomp.diagnosis.fit import Entry, Fit, fit_terms
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.samples import outliers, sensors, split
from gravcomp.diagnosis.samples.halves import Neighbours
from gravcomp.diagnosis.samples.noise import Noise, model_free
from gravcomp.diagnosis.search.criterion import Criterion
from gravcomp.diagnosis.search.gram import Gram
from gravcomp.diagnosis.search.rules import Choice, alternatives, certain, choose
from gravcomp.diagnosis.search.withdrawal import confirmed
from gravcomp.diagnosis.shares import Shares, shares
from gravcomp.diagnosis.thresholds import (
    AS_MUCH,
    CLEARLY_LESS,
    HUBER,
    MAD_TO_SIGMA,
    REFINE_SAMPLES,
    ROUNDS,
    SAME_COLUMN,
    SEARCH_SAMPLES,
    SLOW_SHARE,
    SURELY_LESS,
    TINY,
)
from gravcomp.logs.measurement import Measurement


@dataclass(frozen=True)
class Diagnosis:
    """What was found: the fit, the held-out errors and the verdict. Errors (n, k) in the unit of the data.

    ``before`` is of the log as its sensors wrote it; ``left_out`` (n, k) marks gross errors, which no error, share or
    noise counts; ``noise`` no model made, ``over_noise`` is what is left in units of it, ``noise_floor`` is that of the
    fit; ``notes`` tell what columns got wrong.
    """

    data: Measurement
    is_test: np.ndarray
    blocks: np.ndarray
    before: np.ndarray
    after: np.ndarray
    fit: Fit
    verdict: str
    alternatives: list[list[str]]
    drivers: list[dict]
    shares: Shares
    noise_floor: float
    noise: Noise
    over_noise: float
    untestable: dict[str, str]
    left: list[dict]
    left_out: np.ndarray
    notes: tuple[str, ...]


@threadpool_limits.wrap(limits=1, user_api="blas")  # the matrices are small: threads only wait for one another
def diagnose(data: Measurement, model: Model, seed: int = 0, holdout: str = "blocks", progress=None) -> Diagnosis:
    """Diagnose one measurement; model brings the effects that are already known."""
    tick = progress or (lambda what: None)
    model, left_aside = model.applicable_to(data)
    checked = sensors.check(model.corrected(data))
    written = checked.data.force - checked.data.nominal - model.predict(checked.data)
    blocks = split.block_labels(checked.data, seed)
    is_test = split.held_out(checked.data, blocks, seed, holdout)
    train = np.flatnonzero(~is_test)
    read = _best_reading(checked.data, model, train, blocks, tick)
    data, of_sensors, before, found, fit, after = vars(read).values()
    rows = _search_rows(train)
    left_out = np.zeros(after.shape, bool)
    for side in (train, np.flatnonzero(is_test)):
        left_out[side] = outliers.gross(data, after[side] - _hidden(data, after[side]), side)
    left_out &= ~data.is_undecided
    use = ~left_out & ~data.is_undecided
    left = leftover.find(data, after, rows, blocks, found.noise, seed)
    tick("report")
    noise = model_free(data, after, use)
    counted = is_test[:, None] & ~left_out
    in_fit = use & ~is_test[:, None]
    share = shares(data, fit, in_fit / np.maximum(found.noise, TINY), counted, written, after)
    share.unique.update(_shares_of_sensors(of_sensors, counted, written, before))
    whole = Fit((*of_sensors, *fit.effects), fit.corrections)
    unseen = sum(
        (e.term.candidate.unseen(data, e.parameters, is_test) for e in fit.effects), np.zeros(data.shape, bool)
    )
    over_noise = verdict.remainder(after, ~left_out & ~data.is_reversing & ~unseen, is_test, noise)
    notes, is_hidden = _words(data, after, fit)
    if unseen.any():
        notes.append(f"a step lies among rows that were held out: {unseen.any(axis=1).sum()} rows are not judged")
    return Diagnosis(
        data=data,
        is_test=is_test,
        blocks=blocks,
        before=written,
        after=after,
        fit=whole,
        verdict=verdict.verdict(whole, share, left, np.inf if is_hidden else over_noise),
        alternatives=alternatives(found.criterion, found.choice) + _identities(fit),
        drivers=leftover.drivers(data, counted, written, after, fit, left),
        shares=share,
        noise_floor=_noise_floor(after[train], use[train], fit),
        noise=noise,
        over_noise=over_noise,
        untestable=_untestable(data, rows, blocks),
        left=left,
        left_out=left_out,
        notes=(*checked.notes, *left_aside, *notes),
    )


@dataclass(frozen=True)
class _Attempt:
    """One reading of the log and what was found in it; errors (n, k)."""

    data: Measurement
    of_sensors: list[Entry]
    before: np.ndarray
    found: "_Found"
    fit: Fit
    after: np.ndarray


def _best_reading(data: Measurement, model: Model, train, blocks, tick) -> _Attempt:
    """The sensors are looked at once more beside what was found: it hides a lag as long as the model lacks it."""
    readings = _as_right_sensors_write(data)
    best = _best([_attempt(*reading, model, train, blocks, tick) for reading in readings], train)
    if len(readings) > 1 or not best.fit.effects:
        return best
    beside = sum(entry.force(best.data) for entry in best.fit.effects)
    _, *others = _as_right_sensors_write(data, beside)
    return _best([best, *(_attempt(*reading, model, train, blocks, tick) for reading in others)], train)


def _search_rows(train: np.ndarray) -> np.ndarray:
    return train[np.linspace(0, len(train) - 1, min(len(train), SEARCH_SAMPLES)).astype(int)]


def _attempt(data: Measurement, of_sensors: list[Entry], model: Model, train, blocks, tick) -> _Attempt:
    """Once more without the samples whose direction an effect found does not tell, where there are such."""
    tick("effects")
    first = _read(data, of_sensors, model, train, blocks, tick)
    own = [entry.term.candidate.doubt(data, entry.parameters) for entry in first.fit.effects]
    slow = sum(own, np.zeros(data.shape)) > first.found.noise
    if not slow.any() or (slow.mean(axis=0) > SLOW_SHARE).any():
        return first
    return _read(replace(data, slow=slow), of_sensors, model, train, blocks, lambda what: None)


def _read(data: Measurement, of_sensors: list[Entry], model: Model, train, blocks, tick) -> _Attempt:
    before = data.force - data.nominal - model.predict(data)
    found = _search(data, before, _search_rows(train), model.known, tick)
    tick("fit")
    fit = _fit(data, before, train, blocks, found, model.known)
    noise = model_free(data, before - fit.predict(data), ~data.is_undecided)
    choice = certain(
        found.criterion, found.choice, noise.sigma, _imitable(data, before, _search_rows(train), fit, noise)
    )
    if choice != found.choice:
        found = replace(found, choice=choice)
        fit = _fit(data, before, train, blocks, found, model.known)
    return _Attempt(data, of_sensors, before, found, fit, before - fit.predict(data))


def _imitable(data: Measurement, before, rows, fit: Fit, noise: Noise) -> dict[str, np.ndarray]:
    """By name of an effect the part (k,) of what effects leave that is of the halves, by direction, that it has."""
    forces = {entry.name: entry.force(data) for entry in fit.effects}
    near, silent = Neighbours.of(data, rows), np.zeros(data.n_axes)
    rest = near.halves(before - sum(forces.values(), np.zeros(data.shape)), noise.sigma)
    return {name: rest.shared_with(near.halves(force, silent)) for name, force in forces.items()}


def _best(attempts: list[_Attempt], train: np.ndarray) -> _Attempt:
    """The plain reading, unless another leaves clearly less, no more with fewer terms, or surely less with the same."""
    plain, *others = attempts
    use = ~plain.data.is_undecided[train]

    def left(attempt):
        own = attempt.after[train]
        return float(np.sqrt(np.mean(own[use & ~outliers.gross(attempt.data, own, train)] ** 2)))

    for other in others:
        n_terms = len(other.fit.entries) + len(other.of_sensors) - len(plain.of_sensors)
        ratio = left(other) / max(left(plain), TINY)
        is_same_story = {entry.name for entry in other.fit.entries} <= {entry.name for entry in plain.fit.entries}
        is_sure = is_same_story and -2.0 * use.sum() * np.log(max(ratio, TINY)) > SURELY_LESS
        if ratio < CLEARLY_LESS or is_sure or (ratio < AS_MUCH and n_terms < len(plain.fit.entries)):
            return other
    return plain


def _as_right_sensors_write(data: Measurement, beside=0.0) -> list[tuple[Measurement, list[Entry]]]:
    """Readings of the log without the effects of sensors that it shows by itself, and these.

    The first has only those that no effect of the machine could show; the others are sought beside a force (n, k), and
    are none where they leave an axis without a sample whose direction is sure.
    """
    found, doubtful = [], []
    for effect in sorted((kind() for kind in EFFECTS), key=lambda effect: not effect.is_certain):
        seen = effect.seen_in(data if effect.is_certain else replace(data, nominal=data.nominal + beside))
        if seen:
            parameters = {name: value for name, (value, _) in seen.items()}
            intervals = {name: (value - half, value + half) for name, (value, half) in seen.items()}
            entry = Entry(Term(effect, tuple(parameters)), parameters, intervals, 0.0)
            if effect.is_certain:
                data = effect.corrected(data, parameters)
                found.append(entry)
            else:
                doubtful.append((effect.corrected(data, parameters), entry))
    can_be_judged = [(read, entry) for read, entry in doubtful if not read.is_undecided.all(axis=0).any()]
    return [(data, found)] + [(read, [*found, entry]) for read, entry in can_be_judged]


def _shares_of_sensors(entries: list[Entry], use: np.ndarray, written: np.ndarray, before: np.ndarray) -> dict:
    total = max(np.sum(written[use] ** 2), TINY)
    share = float(np.clip(1.0 - np.sum(before[use] ** 2) / total, 0.0, 1.0))
    return {entry.name: share / len(entries) for entry in entries}


def _words(data: Measurement, after: np.ndarray, fit: Fit) -> tuple[list[str], bool]:
    """Lines on what the remainder, the changes and the gain say, and whether the remainder hides a direction."""
    notes = []
    level = np.zeros(data.n_axes) if data.has_velocity else sensors.two_valued(after)[0]
    for i in np.flatnonzero(level):
        size = f"{level[i]:.3g} {data.effort_units[i]}"
        notes.append(f"what is left of axis {i + 1} is two-valued, {size} up and down, as friction with unknown "
                     "direction of approach: log the approach velocity")  # fmt: skip
    for entry in fit.effects:
        labels = entry.term.labels
        single = {
            label for contrast in entry.term.candidate.contrasts(labels) if len(contrast) == 1 for label in contrast
        }
        if any(entry.intervals[label][1] < 0.0 for label in single if label in entry.intervals):
            notes.append(f"the model has too much {entry.name}: the change found is negative")
    for i, gain in enumerate(data.once(sensors.gains)):
        if not sensors.is_a_gain(gain):
            notes.append(f"the effort of axis {i + 1} is {gain:.3g} times the model: a unit or a sign; check both")
    return notes, bool(level.any())


@dataclass(frozen=True)
class _Found:
    """What the search ends with; noise (k,); hidden (n, k): friction whose direction no column tells."""

    criterion: Criterion
    choice: Choice
    noise: np.ndarray
    hidden: np.ndarray

    @property
    def effects(self) -> list[Term]:
        return [self.criterion.terms[k] for k in sorted(self.criterion.effects_of(self.choice.members))]

    @property
    def corrections(self) -> list[Term]:
        effects = self.criterion.effects_of(self.choice.members)
        return [self.criterion.terms[k] for k in sorted(self.choice.members - effects)]


def _untestable(data: Measurement, rows: np.ndarray, blocks: np.ndarray) -> dict[str, str]:
    why = {kind.name: kind().unavailable(data) for kind in reversed(EFFECTS)}
    why["whether what is left follows a variable"] = leftover.unavailable(data, rows, blocks)
    return {name: reason for name, reason in why.items() if reason}


def _able(data: Measurement) -> list[Effect]:
    return [effect for effect in (kind() for kind in EFFECTS) if not effect.unavailable(data)]


def _effects(data: Measurement, rows: np.ndarray) -> list[Regressor]:
    return [Regressor.of(effect, data, rows, shape) for effect in _able(data) for shape in effect.shapes(data)]


def _scanned_effects(data: Measurement, rows: np.ndarray, residuals: list[np.ndarray]) -> list[Regressor]:
    out = []
    for effect in _able(data):
        shapes = set().union(*(effect.scanned_shapes(data, rows, residual) for residual in residuals))
        out += [Regressor.of(effect, data, rows, dict(shape)) for shape in sorted(shapes)]
    return out


def _search(data: Measurement, before: np.ndarray, rows: np.ndarray, known, tick) -> _Found:
    measured, sure = before[rows], (~data.is_undecided[rows]).astype(float)
    effects = [entry for entry in _effects(data, rows) if entry.has_part]
    plain = _without_named(corrections.candidates(data), effects, data, rows)
    independent = np.maximum(sure.sum(axis=0), 2.0)
    unexplained, of_position, ripples, refined = measured, measured, [measured], []
    for turn in range(ROUNDS):
        tick(f"search {turn + 1}")
        hidden = _hidden(data, unexplained)
        is_gross = outliers.gross(data, unexplained - hidden, rows)
        scale = np.maximum(outliers.spread(unexplained - hidden), 1e-9 * np.abs(data.force).max())
        residual, size = measured - hidden, np.abs(unexplained - hidden)
        weight = sure * ~is_gross * (np.minimum(1.0, HUBER * scale / np.maximum(size, TINY)) if turn else 1.0)
        variance = (weight * size**2).sum(axis=0) / np.maximum(weight.sum(axis=0), TINY)
        variance = np.maximum(variance, scale**2 * 1e-6)
        scaled = [ripple * ~is_gross / np.maximum((ripple * ~is_gross).std(axis=0), TINY) for ripple in ripples]
        scanned = corrections.scanned(data, rows, unexplained * ~is_gross, scaled[0])
        scanned += corrections.hinges(data, rows, of_position, ~is_gross)
        named = effects + refined + _scanned_effects(data, rows, scaled)
        entries = named + plain + [Regressor.of(correction, data, rows) for correction in scanned]
        gram = Gram(entries, residual, weight, variance, independent)
        criterion = Criterion([entry.term for entry in entries], gram, len(named), known)
        choice = choose(criterion)
        fitted = _fitted(criterion, choice, entries, residual.shape)
        nothing = np.zeros_like(residual)
        unexplained = measured - sum(fitted.values(), nothing)
        is_scanned = {k: criterion.terms[k].candidate.is_scanned for k in fitted}
        ripple = sum((force for k, force in fitted.items() if is_scanned[k]), nothing)
        smooth = sum((fitted[k] for k in criterion.effects_of(choice.members) if not is_scanned[k]), nothing)
        # beside the corrections, and without them: tables may have swallowed a ripple
        ripples = [unexplained + ripple, residual - smooth]
        is_of_position = {k: criterion.terms[k].candidate.is_of_own_position for k in fitted}
        of_position = unexplained + sum((force for k, force in fitted.items() if is_of_position[k]), nothing)
        if turn < ROUNDS - 1:
            refined = _refined(data, before, rows, [criterion.terms[k] for k in criterion.effects_of(choice.members)],
                               np.sqrt(variance))  # fmt: skip
        clean = (unexplained - hidden) * ~is_gross
        independent = np.maximum((sure * ~is_gross).sum(axis=0) / _correlation_length(clean), 2.0)
    left = np.zeros(data.shape)
    left[rows] = hidden
    return _Found(criterion, choice, np.sqrt(variance), left)


def _refined(data: Measurement, before, rows, terms: list[Term], noise) -> list[Regressor]:
    """Chosen effects at the shapes and the parameters that an exact fit gives them: what a coarse choice of shapes, or
    the column of a small parameter, leaves has no name.
    """
    if not any(term.candidate.scales or term.candidate.is_curved for term in terms):
        return []
    few = rows[np.linspace(0, len(rows) - 1, min(len(rows), REFINE_SAMPLES)).astype(int)]
    out = []
    for entry in fit_terms(data, before, few, terms, [], noise).effects:
        own = {name: entry.parameters[name] for name in entry.term.shape if name in entry.parameters}
        shape = {**entry.term.shape, **own}
        if entry.term.candidate.is_curved:
            out.append(Regressor.about(replace(entry.term, shape=shape), data, rows, entry.parameters))
        elif own:
            out.append(Regressor.of(entry.term.candidate, data, rows, shape))
    return out


def _without_named(candidates, effects: list[Regressor], data: Measurement, rows: np.ndarray) -> list[Regressor]:
    """Regressors of the corrections; one whose only column is that of a named effect is that effect."""
    named = [
        [column / np.linalg.norm(column) for entry in effects if entry.by_axis[i] is not None
         for column in entry.by_axis[i].T if column.any()]
        for i in range(data.n_axes)
    ]  # fmt: skip
    out = []
    for entry in (Regressor.of(correction, data, rows) for correction in candidates):
        own = entry.by_axis[entry.term.candidate.axis]
        if own is None:
            continue
        if own.shape[1] == 1:
            unit = own[:, 0] / np.linalg.norm(own)
            if any(abs(unit @ column) > SAME_COLUMN for column in named[entry.term.candidate.axis]):
                continue
        out.append(entry)
    return out


def _hidden(data: Measurement, unexplained: np.ndarray) -> np.ndarray:
    """The part of a two-valued remainder whose sign no column tells, (m, k): friction of an unknown approach."""
    if data.has_velocity:
        return np.zeros_like(unexplained)
    level, centre = sensors.two_valued(unexplained)
    return level * np.sign(unexplained - centre)


def _fitted(criterion: Criterion, choice: Choice, entries: list[Regressor], shape) -> dict[int, np.ndarray]:
    """Force (m, k) of each term of the choice on the rows of the search."""
    out = {}
    for k, (whole, theta) in criterion.coefficients(choice.members).items():
        columns = entries[whole].by_axis
        out[k] = np.column_stack([np.zeros(shape[0]) if c is None else c @ theta for c in columns])
    return out


def _fit(data: Measurement, before: np.ndarray, train: np.ndarray, blocks: np.ndarray, found: _Found, known) -> Fit:
    """Physics that is the whole story is fitted alone, corrections to what it leaves."""
    before = before - found.hidden
    fitted = partial(fit_terms, data, rows=train, noise=found.noise, known=known)
    is_whole, effects = found.choice.is_physics_whole, found.effects
    fit = fitted(residual=before, effects=effects, corrections=[] if is_whole else found.corrections)
    simpler = [_reduced(data, entry) for entry in fit.effects]
    left_out = outliers.gross(data, (before - fit.predict(data))[train], train)
    simpler, plain = confirmed(data, before, train, blocks, simpler, found.corrections, found.noise, left_out)
    together = [] if is_whole else plain
    if left_out.any() or [*simpler, *together] != [entry.term for entry in fit.entries]:
        fit = fitted(residual=before, effects=simpler, corrections=together, left_out=left_out)
    if is_whole and plain:
        on_top = partial(fitted, effects=[], corrections=plain, left_out=left_out)
        beside = on_top(residual=before - fit.predict(data)).predict(data)
        fit = fitted(residual=before, effects=simpler, corrections=[], left_out=left_out, beside=beside)
        fit = Fit(fit.effects, on_top(residual=before - fit.predict(data)).corrections)
    return fit


def _reduced(data: Measurement, entry: Entry) -> Term:
    """The term, or its special case where the general one is not different from it."""
    candidate = entry.term.candidate
    if not candidate.reduces(entry.intervals):
        return entry.term
    special = effect_named(candidate.special_case)
    axes = {label.axis for label in entry.term.labels}
    return Term(special, tuple(label for label in special.columns(data, {}) if label.axis in axes))


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


def _noise_floor(after: np.ndarray, use: np.ndarray, fit: Fit) -> float:
    """RMS of the remainder on the training samples to use, over the axes, for its degrees of freedom."""
    freedom = np.maximum(use.sum(axis=0) - fit.n_parameters / after.shape[1], 1.0)
    return float(np.sqrt(np.mean((after**2 * use).sum(axis=0) / freedom)))
