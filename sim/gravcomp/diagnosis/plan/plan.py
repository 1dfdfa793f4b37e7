"""The shortest next measurement that tells apart effects which a log cannot.

Each rival explanation is fitted to the log. If A is true, B can only follow A's force with its own parameters, which
both measurements together hold fast: what B misses on the rows X of a next measurement, in units of the noise,

    E(A, B; X) = min over b of |F_A - F_B - J_B b|^2 / s^2 on the log and X, less the same on the log alone,

is the expected difference of their scores (twice the log evidence). B may also have another offset and another friction
in X than in the log: what a change between the two measurements could explain tells nothing. Holds are chosen one by
one, motions from a list, so that the least E of any two rivals reaches ``ENOUGH`` with the fewest rows (T-optimal:
Atkinson and Fedorov, 1975). To the holds as many of the log are added, to be taken again: they show a change in time.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations, product

import numpy as np
from scipy.interpolate import CubicSpline

from gravcomp.diagnosis.candidate import Regressor, Term
from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.effects import EFFECTS, effect_named
from gravcomp.diagnosis.fit import fit_terms
from gravcomp.diagnosis.search.gram import pseudo_inverse
from gravcomp.diagnosis.thresholds import (
    ENOUGH,
    FEWEST_HOLDS,
    MOST_HOLDS,
    PLAN_NEAR,
    PLAN_POOL,
    PLAN_POSES,
    PLAN_ROUNDING,
    PLAN_ROWS,
    PLAN_SPEEDS,
    PLAN_STARTS,
    PLAN_STROKES,
    PLAN_WORTH,
    TINY,
    TRIFLE,
)
from gravcomp.logs.clock import usual_step
from gravcomp.logs.joining import stacked
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.protocol import PoseError


@dataclass(frozen=True, eq=False)
class Rival:
    """One explanation of the log: effects with their parameters. key: the names that only it has."""

    key: tuple[str, ...]
    effects: tuple[tuple[str, Mapping[str, float]], ...]

    def force(self, data: Measurement) -> np.ndarray:
        """(n, k)."""
        return sum((effect_named(name).predict(data, own) for name, own in self.effects), np.zeros(data.shape))

    def tangent(self, data: Measurement) -> np.ndarray:
        """Derivatives of the force by every parameter, (n, k, p), central differences."""
        columns = []
        for name, own in self.effects:
            for key, value in own.items():
                step = 1e-4 * (abs(value) or 1e-3)
                up, down = (effect_named(name).predict(data, {**own, key: value + s}) for s in (step, -step))
                columns.append((up - down) / (2.0 * step))
        return np.stack(columns, axis=-1)


@dataclass(frozen=True)
class Reach:
    """Where and how fast the machine may go: low, high (k,) in the units of the log, speed (k,) per second."""

    low: np.ndarray
    high: np.ndarray
    speed: np.ndarray

    @classmethod
    def of(cls, data: Measurement) -> "Reach":
        """The log's own, or the machine's positions where there is one."""
        bounds = None if data.robot is None else data.robot.bounds
        low, high = (data.q.min(axis=0), data.q.max(axis=0)) if bounds is None else (bounds.q_least, bounds.q_most)
        speed = np.quantile(np.abs(data.v), 0.95, axis=0) if data.has_velocity else np.zeros(data.n_axes)
        return cls(low, high, speed)


@dataclass(frozen=True)
class Plan:
    """rows: the next measurement, with the model's forces, None where there is none; evidence: the least E of two
    rivals, worst: the names of these two; same: rivals that no measurement of this machine tells apart.
    """

    rows: Measurement | None
    is_motion: bool
    evidence: float
    worst: tuple[Rival, Rival] | None
    same: tuple[tuple[str, ...], ...]

    @property
    def is_enough(self) -> bool:
        return self.rows is not None and self.evidence >= ENOUGH


def rivals(
    data: Measurement, residual: np.ndarray, effects: Sequence[tuple[str, Mapping]],
    alternatives: Sequence[Sequence[str]], noise: np.ndarray,
) -> list[Rival]:  # fmt: skip
    """The explanation that the report names, and those with one effect replaced by an alternative, or by two, that fit
    the log as well. residual (n, k): measured less modelled; noise (k,).
    """
    found = []
    for names in alternatives:
        others = [entry for entry in effects if entry[0] != names[0]]
        options = [(names[0],), *((name,) for name in names[1:]), *combinations(names[1:], 2)]
        for option in dict.fromkeys(options):
            fitted = _fitted(data, residual, [name for name, _ in others], option, effects, noise)
            if fitted:
                found.append(fitted)
    best = min((score for _, score in found), default=0.0)
    near = [rival for rival, score in sorted(found, key=lambda pair: pair[1]) if score < best + PLAN_NEAR]
    return [rival for rival in near if not any({*other.key} < {*rival.key} for other in near)]


def plan(data: Measurement, rivals: Sequence[Rival], noise: np.ndarray, reach: Reach, seed: int = 0) -> Plan:
    """The shortest measurement that tells all rivals apart: holds after holds, a motion after a motion."""
    is_motion, rng = bool(data.is_motion.mean() > 0.5), np.random.default_rng(seed)
    pool, run = _motions(data, reach, rng) if is_motion else (_holds(data, reach, rng), None)
    groups = [np.arange(len(pool.t_s))] if run is None else [np.flatnonzero(run == k) for k in range(run.max() + 1)]
    contests = [c for c in _contests(data, pool, rivals, noise) if max(c.of(rows) for rows in groups) >= PLAN_WORTH]
    same = _not_told_apart(rivals, contests)
    if not contests:
        return Plan(None, is_motion, 0.0, None, same)
    rows, evidence, worst = _shortest_motion(contests, groups) if is_motion else _fewest_holds(contests)
    planned = _taken(pool, rows) if is_motion else _with_controls(data, _taken(pool, rows), rng)
    return Plan(planned, is_motion, evidence, worst, same)


def contested(d: Diagnosis) -> list[list[str]]:
    """Alternatives of a diagnosis that some measurement could tell apart."""
    return without_identities(d.alternatives, {entry.name: entry.parameters for entry in d.fit.effects})


def without_identities(alternatives: Sequence[Sequence[str]], effects: Mapping[str, Mapping]) -> list[list[str]]:
    """Alternatives without the names that are the same force on any data; effects: named ones, their parameters."""
    same = {name: effect_named(name).same_as(own) for name, own in effects.items()}
    kept = [[names[0], *(name for name in names[1:] if name not in same.get(names[0], ()))] for names in alternatives]
    return [names for names in kept if len(names) > 1]


def correlated(noise: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Noise (k,) as independent samples would have it, from what is left (n, k): neighbours may repeat one another."""
    lag = (after[1:] * after[:-1]).sum(axis=0) / np.maximum((after**2).sum(axis=0), TINY)
    lag = np.clip(lag, 0.0, 0.9)
    return np.maximum(noise, after.std(axis=0)) * np.sqrt((1.0 + lag) / (1.0 - lag))


def _fitted(data, residual, others, option, effects, noise) -> tuple[Rival, float] | None:
    """The rival that has these effects, and its score; None where one of them cannot be fitted."""
    rows = np.arange(len(residual))
    known = dict(effects)
    names = [*others, *option]
    terms, plain = [], residual
    for name in names:
        term = _term(data, plain, name, known.get(name))
        if term is None:
            return None
        terms.append(term)
    fit = fit_terms(data, residual, rows, terms, [], noise)
    left = (residual - fit.predict(data))[~data.is_undecided.any(axis=1)] / noise
    size = left.size
    score = size * np.log(max(np.sum(np.minimum(left**2, 16.0)) / size, TINY)) + fit.n_parameters * np.log(size)
    return Rival(tuple(option), tuple((entry.name, dict(entry.parameters)) for entry in fit.effects)), float(score)


def _term(data: Measurement, residual: np.ndarray, name: str, known: Mapping | None) -> Term | None:
    """The effect with the shape that goes best with the residual; one that is known already keeps its labels."""
    best = None
    for effect in (kind() for kind in EFFECTS if kind.name == name):
        if effect.unavailable(data):
            continue
        shapes = effect.shapes(data)
        if not shapes and effect.is_scanned:
            shapes = [dict(shape) for shape in effect.scanned_shapes(data, np.arange(len(residual)), residual)]
        for shape in shapes:
            entry = Regressor.of(effect, data, np.arange(len(residual)), shape)
            left = sum(_left(x, residual[:, i]) for i, x in enumerate(entry.by_axis))
            price = len(entry.term.labels) * np.log(len(residual))
            score = residual.size * np.log(max(left, TINY)) + price
            if best is None or score < best[0]:
                best = (score, entry.term)
    return best[1] if best else None


def _left(x: np.ndarray | None, y: np.ndarray) -> float:
    if x is None:
        return float(y @ y)
    theta = np.linalg.lstsq(x, y, rcond=1e-9)[0]
    return float(np.sum((y - x @ theta) ** 2))


@dataclass(frozen=True)
class _Contest:
    """What B misses of A, on the log (as normal equations) and on the rows of the pool, in units of the noise.

    miss (m, k); tangent (m, k, p), columns scaled to one on the log; gram (p, p), cross (p,) and energy of the log.
    """

    pair: tuple[Rival, Rival]
    miss: np.ndarray
    tangent: np.ndarray
    gram: np.ndarray
    cross: np.ndarray
    energy: float

    def evidence(self, gram: np.ndarray, cross: np.ndarray, energy: float) -> float:
        """E of rows with these normal equations: what is left beside the log, less what is left on the log alone."""
        return _rest(self.gram + gram, self.cross + cross, self.energy + energy) - _rest(
            self.gram, self.cross, self.energy
        )

    def of(self, rows: np.ndarray) -> float:
        x, y = self.tangent[rows].reshape(-1, len(self.cross)), self.miss[rows].ravel()
        return self.evidence(x.T @ x, x.T @ y, float(y @ y))


def _rest(gram: np.ndarray, cross: np.ndarray, energy: float) -> float:
    inverse, _ = pseudo_inverse(gram)
    return float(energy - cross @ inverse @ cross)


def _contests(data: Measurement, pool: Measurement, rivals: Sequence[Rival], noise: np.ndarray) -> list[_Contest]:
    """All ordered pairs."""
    whole, n = stacked(data, pool), len(data.t_s)
    counts = (~whole.is_undecided).astype(float)[..., None] / noise[:, None]
    forces = {rival: rival.force(whole)[..., None] * counts for rival in rivals}
    changes = _changes(whole, n)
    tangents = {rival: np.concatenate([rival.tangent(whole), changes], axis=-1) * counts for rival in rivals}
    out = []
    for a, b in permutations(rivals, 2):
        x, y = tangents[b], (forces[a] - forces[b])[..., 0]
        if _contains(a, b):
            y = y * _to_be_seen(y[:n], x[:n], forces[b][:n])
        x = x / np.maximum(np.sqrt((x**2).sum(axis=(0, 1))), TINY)
        on_log = x[:n].reshape(-1, x.shape[-1])
        out.append(_Contest((a, b), y[n:], x[n:], on_log.T @ on_log, on_log.T @ y[:n].ravel(), np.sum(y[:n] ** 2)))
    return out


def _contains(a: Rival, b: Rival) -> bool:
    """Is b the special case of a?"""
    return len(a.key) == len(b.key) == 1 and effect_named(a.key[0]).special_case == b.key[0]


def _to_be_seen(difference: np.ndarray, tangent: np.ndarray, force: np.ndarray) -> float:
    """How many times larger a general form's difference from its special case would have to be to count at all.

    The fit of the general form may be the special case to the noise: what has to be shut out is a difference of a
    trifle of the force's energy. One that is the special case to rounding has no direction to look in.
    """
    x, y = tangent.reshape(-1, tangent.shape[-1]), difference.ravel()
    own = np.sum((y - x @ np.linalg.lstsq(x, y, rcond=1e-9)[0]) ** 2)
    return float(max(np.sqrt(TRIFLE * np.sum(force**2) / own), 1.0)) if own > PLAN_ROUNDING else 1.0


def _changes(whole: Measurement, n: int) -> np.ndarray:
    """Another offset and another friction of each axis from row n on, (m, k, p)."""
    later = (np.arange(len(whole.t_s)) >= n)[:, None, None] * np.eye(whole.n_axes)
    return later if not whole.has_velocity else np.concatenate([later, later * whole.direction[..., None]], axis=-1)


def _not_told_apart(rivals: Sequence[Rival], contests: Sequence[_Contest]) -> tuple[tuple[str, ...], ...]:
    """Pairs of rivals that stand in no contest, by their names."""
    told = {frozenset(contest.pair) for contest in contests}
    return tuple((" and ".join(a.key), " and ".join(b.key)) for a, b in combinations(rivals, 2)
                 if frozenset((a, b)) not in told)  # fmt: skip


def _holds(data: Measurement, reach: Reach, rng: np.random.Generator) -> Measurement:
    """Holds of poses of the log and of the machine's reach, approached from either side of each axis, at several speeds
    up to the fastest.
    """
    own = rng.integers(len(data.t_s), size=PLAN_POOL // 2)
    q, nominal = data.q[own], data.nominal[own]
    more = data.robot.workspace(PLAN_POOL // 2, int(rng.integers(2**31))) if data.robot is not None else (
        rng.uniform(reach.low, reach.high, (PLAN_POOL // 2, data.n_axes)))  # fmt: skip
    if data.force_at is not None:
        q, nominal = np.vstack([q, more]), np.vstack([nominal, data.force_at(more)])
    v = rng.choice([-1.0, 1.0], q.shape) * rng.choice(PLAN_SPEEDS, (len(q), 1)) * reach.speed
    t_s = data.t_s[-1] + usual_step(data.t_s, data.runs) * (1 + np.arange(len(q)))
    return _planned(data, t_s, q, v if data.has_velocity else None, nominal, np.zeros(len(q), int))


def _motions(data: Measurement, reach: Reach, rng: np.random.Generator) -> tuple[Measurement, np.ndarray]:
    """Motions, each a run, and the number of the run of every row, from 0."""
    step = usual_step(data.t_s, data.runs)
    parts = [*_to_and_fro(data, step), *_sweeps(data, reach, step, rng)]
    run = np.repeat(np.arange(len(parts)), [len(q) for q, _ in parts])
    q, nominal = (np.concatenate(column) for column in zip(*parts, strict=True))
    v = np.concatenate([np.gradient(own, step, axis=0) for own, _ in parts])
    t_s = data.t_s[-1] + step * np.concatenate([1 + np.arange(len(own)) for own, _ in parts])
    return _planned(data, t_s, q, v, nominal, run), run


def _to_and_fro(data: Measurement, step: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Positions and forces along the log's own path, where the machine has been."""
    path = np.flatnonzero(data.runs == np.bincount(data.runs).argmax())
    n = len(path)
    for start, stroke, speed in product(PLAN_STARTS, PLAN_STROKES, PLAN_SPEEDS):
        half = stroke * n * min(start, 1.0 - start)
        if half >= 2.0:
            at = start * n + half * np.sin(speed * np.arange(min(PLAN_ROWS[-1], 4 * n)) / half)
            yield tuple(np.column_stack([np.interp(at, np.arange(n), own) for own in values[path].T])
                        for values in (data.q, data.nominal))  # fmt: skip


def _sweeps(data: Measurement, reach: Reach, step: float, rng) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Positions and forces of motions through all of the reach; none where the model is not known there."""
    if data.force_at is None:
        return
    rows = np.arange(PLAN_ROWS[-1])
    for speed, wide in product(PLAN_SPEEDS[:3], (1.0, 0.5)):
        if data.robot is not None:
            poses = data.robot.workspace(PLAN_POSES, int(rng.integers(2**31)))
            poses = poses.mean(axis=0) + wide * (poses - poses.mean(axis=0))
            spline = CubicSpline(np.arange(PLAN_POSES), poses)
            rate = speed * np.min(
                reach.speed / np.maximum(np.abs(spline(np.linspace(0, PLAN_POSES - 1, 500), 1)).max(axis=0), TINY)
            )
            q = spline((PLAN_POSES - 1) * (0.5 - 0.5 * np.cos(2.0 * rate * step * rows / (PLAN_POSES - 1))))
        else:
            half = wide * (reach.high - reach.low) / 2.0
            angle = speed * reach.speed / np.maximum(half, TINY) * step * rows[:, None]
            q = (reach.high + reach.low) / 2.0 + half * (0.7 * np.sin(angle) + 0.3 * np.sin(0.618 * angle + 1.0))
        try:
            yield q, data.force_at(q)
        except PoseError:  # between two poses of the workspace
            continue


def _planned(data: Measurement, t_s, q, v, nominal, run) -> Measurement:
    """Rows to come: what the model says stands for what will be measured; the machine stays as warm as it is."""
    temp_c = None if data.temp_c is None else np.full(len(t_s), data.temp_c[-1])
    return replace(data, name="plan", t_s=t_s, q=q, v=v, force=nominal, nominal=nominal, temp_c=temp_c,
                   run=run + data.runs.max() + 1, unsure=None)  # fmt: skip


def _fewest_holds(contests: Sequence[_Contest]):
    """Holds, each the one that helps the least decided contest most, until all are decided; the least E, its rivals."""
    chosen: list[int] = []
    normal = [(c.gram.copy(), c.cross.copy()) for c in contests]
    evidence = np.zeros(len(contests))
    while (evidence.min() < ENOUGH or len(chosen) < FEWEST_HOLDS) and len(chosen) < MOST_HOLDS:
        weakest = int(evidence.argmin())
        gain = _gains(contests[weakest], *normal[weakest])
        gain[chosen] = -1.0
        chosen.append(int(gain.argmax()))
        for k, contest in enumerate(contests):
            x, y = contest.tangent[chosen[-1]], contest.miss[chosen[-1]]
            normal[k] = (normal[k][0] + x.T @ x, normal[k][1] + x.T @ y)
            evidence[k] = contest.of(np.array(chosen))
    return np.array(chosen), float(evidence.min()), contests[int(evidence.argmin())].pair


def _gains(contest: _Contest, gram: np.ndarray, cross: np.ndarray) -> np.ndarray:
    """What each row of the pool would add to E, (m,): its residual in units of what it is known to."""
    inverse, _ = pseudo_inverse(gram)
    left = contest.miss - contest.tangent @ (inverse @ cross)
    spread = np.eye(left.shape[1]) + contest.tangent @ inverse @ contest.tangent.transpose(0, 2, 1)
    return np.einsum("mk,mk->m", left, np.linalg.solve(spread, left[..., None])[..., 0])


def _shortest_motion(contests: Sequence[_Contest], motions: list[np.ndarray]):
    """Rows of the motion that decides every contest in the fewest rows, the best of the longest where none does; the
    least E, and the rivals of it.
    """
    best = None
    for n in PLAN_ROWS:
        for whole in motions:
            evidence = [contest.of(whole[:n]) for contest in contests]
            weakest = int(np.argmin(evidence))
            if best is None or evidence[weakest] > best[1]:
                best = (whole[:n], float(evidence[weakest]), contests[weakest].pair)
        if best[1] >= ENOUGH:
            break
    return best


def _with_controls(data: Measurement, rows: Measurement, rng: np.random.Generator) -> Measurement:
    """The holds, and as many of the log again, mixed."""
    again = rng.choice(len(data.t_s), min(len(rows.t_s), len(data.t_s)), replace=False)
    mixed = _taken(stacked(rows, _taken(data, again)), rng.permutation(len(rows.t_s) + len(again)))
    return replace(mixed, t_s=data.t_s[-1] + usual_step(data.t_s, data.runs) * (1 + np.arange(len(mixed.t_s))))


def _taken(pool: Measurement, rows: np.ndarray) -> Measurement:
    def of(values):
        return None if values is None else values[rows]

    return replace(pool, t_s=of(pool.t_s), q=of(pool.q), v=of(pool.v), force=of(pool.force), nominal=of(pool.nominal),
                   temp_c=of(pool.temp_c), run=None, unsure=None)  # fmt: skip
