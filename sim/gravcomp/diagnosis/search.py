"""Which set of terms explains a residual: information criterion over sets of effects and corrections.

A term is an effect with one shape, or an empirical correction; it is linear in its coefficients. All sets are scored
from Gram matrices, so thousands of sets cost seconds. Score of a set, the smaller the better:
sum over axes of m_i log(RSS_i / m_i) + rank log(sum m_i) + price of each term,
m_i: samples of axis i that count as independent. A price stands for the number of terms that were tried.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gravcomp.diagnosis.corrections import Correction
from gravcomp.diagnosis.effects.base import Effect

PHYSICAL_PRICE = 8.0
EMPIRICAL_PRICE = 20.0
SCAN_PRICE = 14.0  # 2 log of the number of frequencies scanned
TOLERANCE = 9.0  # sets this close in score cannot be told apart
_NEGATIVE_Z = 3.0
_MAX_TERMS = 14
_CANCELLATION = 3.0
_TRIFLE = 0.005
_BESIDE_CORRECTION = 0.1
_MISSED = 0.005  # of the variance that can be explained
_IMPOSSIBLE = 1e12
_SINGULAR = 1e-9
_VAGUE = 4  # names
_SAME_SCORE = 1e-6  # what lies within the span of the other terms adds nothing
_PROMISING = 20  # candidates of a move that are scored exactly


@dataclass(frozen=True, eq=False)
class Term:
    """One candidate: an effect with a shape, or a correction; labels name its columns."""

    source: Effect | Correction
    labels: tuple[str, ...]
    shape: dict = field(default_factory=dict)

    @property
    def is_physical(self) -> bool:
        return isinstance(self.source, Effect)

    @property
    def name(self) -> str:
        return self.source.name if self.is_physical else self.source.label

    @property
    def is_directional(self) -> bool:
        return any("_pos_" in label for label in self.labels)

    @property
    def price(self) -> float:
        if not self.is_physical:
            return EMPIRICAL_PRICE + (SCAN_PRICE if self.source.kind == "wave" else 0.0)
        scanned = SCAN_PRICE if self.source.name == "cogging" else 0.0
        return PHYSICAL_PRICE + self.source.complexity + scanned


class Evidence:
    """Scores sets of terms on one residual.

    columns: per term a list over axes of (n, p) arrays or None; residual, weight (n, k); variance (k,) of the noise;
    independent (k,) number of independent samples.
    """

    def __init__(self, terms, columns, residual, weight, variance, independent):
        self.terms, self.m, self.variance = terms, independent, variance
        sizes = [len(term.labels) for term in terms]
        starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self.place = [np.arange(a, b) for a, b in pairwise(starts)]
        n_columns, n_axes = starts[-1], residual.shape[1]
        self.gram = np.zeros((n_axes, n_columns, n_columns))
        self.cross = np.zeros((n_axes, n_columns))
        self.energy = np.zeros(n_axes)
        scale = np.zeros(n_columns)
        for i in range(n_axes):
            here = [k for k in range(len(terms)) if columns[k][i] is not None]
            index = np.concatenate([self.place[k] for k in here])
            x = np.hstack([columns[k][i] for k in here])
            w = weight[:, i] * (independent[i] / weight[:, i].sum())
            xw = x * w[:, None]
            self.gram[i][np.ix_(index, index)] = xw.T @ x
            self.cross[i][index] = xw.T @ residual[:, i]
            self.energy[i] = w @ residual[:, i] ** 2
            scale[index] += np.einsum("nk,nk->k", xw, x) / variance[i]
        self.scale = np.zeros(n_columns)
        np.divide(1.0, np.sqrt(scale), out=self.scale, where=scale > 0.0)
        self.normed_gram = np.einsum("iab,i->ab", self.gram, 1.0 / variance) * self.scale[:, None] * self.scale
        self.normed_cross = np.einsum("ia,i->a", self.cross, 1.0 / variance) * self.scale
        self.floor = 1e-12 * np.maximum(self.energy, 1e-300) / independent
        self.is_physics_whole = False
        self._cache: dict[frozenset, float] = {}

    def solve(self, members) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        """Column indices, coefficients, their covariance and the rank of a set."""
        index = np.concatenate([self.place[k] for k in sorted(members)])
        s = self.scale[index]
        inverse, rank = _pseudo_inverse(self.normed_gram[np.ix_(index, index)])
        return index, inverse @ self.normed_cross[index] * s, inverse * s[:, None] * s, rank

    def score(self, members) -> float:
        key = frozenset(members)
        if key not in self._cache:
            self._cache[key] = self._score(key)
        return self._cache[key]

    def _score(self, members) -> float:
        rss, rank = self.energy, 0
        if members:
            index, theta, covariance, rank = self.solve(members)
            if self._is_impossible(members, index, theta, covariance):
                return _IMPOSSIBLE
            fitted = np.einsum("iab,a,b->i", self.gram[:, index[:, None], index], theta, theta)
            if self._cancels(members, index, theta, fitted.sum()):
                return _IMPOSSIBLE
            rss = np.maximum(self.energy - 2.0 * self.cross[:, index] @ theta + fitted, 0.0)
        likelihood = np.sum(self.m * np.log(np.maximum(rss / self.m, self.floor)))
        return float(likelihood + rank * np.log(self.m.sum()) + sum(self.terms[k].price for k in members))

    def _cancels(self, members, index, theta, total) -> bool:
        """Terms that are large only to cancel one another imitate something else."""
        if len(members) < 2:
            return False
        value = dict(zip(index, theta, strict=True))
        single = 0.0
        for k in members:
            own = np.array([value[c] for c in self.place[k]])
            single += np.einsum("iab,a,b->", self.gram[:, self.place[k][:, None], self.place[k]], own, own)
        return single > _CANCELLATION * total

    def _is_impossible(self, members, index, theta, covariance) -> bool:
        """A coefficient that physics makes positive is clearly negative."""
        position = {column: a for a, column in enumerate(index)}
        for k in members:
            term = self.terms[k]
            for contrast in term.source.contrasts(list(term.labels)) if term.is_physical else ():
                c = np.zeros(len(index))
                for label, factor in contrast.items():
                    if label in term.labels:
                        c[position[self.place[k][term.labels.index(label)]]] = factor
                if c @ theta < -_NEGATIVE_Z * np.sqrt(max(c @ covariance @ c, 1e-300)):
                    return True
        return False

    def pick(self) -> frozenset:
        """The best set. Physics that misses next to nothing of what can be explained at all stays whole, and
        corrections may only come on top of it; otherwise effects and corrections compete freely.
        """
        physical = [k for k, term in enumerate(self.terms) if term.is_physical]
        everything = range(len(self.terms))
        effects = self._exchange(self._beam(physical), physical)
        effects = self._by_direction(self._substantial(self._simplest(effects), _TRIFLE))
        starts = {frozenset(), effects}
        free = min((self._climb(start, everything) for start in starts), key=self.score)
        free = self._exchange(free, everything)
        missed, explained = self._left(effects) - self._left(free), self._left(frozenset()) - self._left(free)
        self.is_physics_whole = bool(effects) and missed < _MISSED * explained
        if self.is_physics_whole:
            return self._climb(effects, everything, locked=effects)
        if any(not self.terms[k].is_physical for k in free):
            free = self._substantial(free, _BESIDE_CORRECTION)
            corrections = [k for k in everything if not self.terms[k].is_physical]
            free = self._unambiguous(self._climb(free, corrections, locked=free))
            free = self._climb(free, corrections, locked=free)
        return free

    def _unambiguous(self, members: frozenset) -> frozenset:
        """Beside corrections, a name that many others could take as well says nothing: drop it."""
        vague = {names[0] for names in self.alternatives(members) if len(names) > _VAGUE}
        return frozenset(k for k in members if not (self.terms[k].is_physical and self.terms[k].name in vague))

    def _simplest(self, members: frozenset) -> frozenset:
        """Use the special case of an effect (Coulomb for Stribeck) where the general one gains next to nothing."""
        for k in sorted(members):
            special, rest = self.terms[k].source.special_case, members - {k}
            options = [j for j, term in enumerate(self.terms) if term.name == special and self._fits(rest, j)]
            if not options:
                continue
            best = rest | {min(options, key=lambda j: self.score(rest | {j}))}
            gain = self._left(best) - self._left(members)
            if gain < _TRIFLE * (self._left(frozenset()) - self._left(members)) and self.score(best) < _IMPOSSIBLE:
                members = best
        return members

    def _by_direction(self, members: frozenset) -> frozenset:
        """Where one friction differs by direction, the Coulomb friction may too."""
        named = {self.terms[k].name: k for k in members}
        viscous, coulomb = named.get("viscous_friction"), named.get("coulomb_friction")
        if viscous is None or coulomb is None or not self.terms[viscous].is_directional:
            return members
        rest = members - {coulomb}
        both = [j for j, term in enumerate(self.terms) if term.name == "coulomb_friction" and term.is_directional]
        return min((rest | {j} for j in both), key=self.score, default=members)

    def _substantial(self, members: frozenset, least: float) -> frozenset:
        """Drop effects, the weakest first, that alone account for less than a part of what the set explains."""
        while physical := [k for k in members if self.terms[k].is_physical]:
            if len(members) == 1:
                break
            explained = self._left(frozenset()) - self._left(members)
            lost = {k: self._left(members - {k}) - self._left(members) for k in physical}
            weakest = min(lost, key=lost.get)
            if lost[weakest] >= least * explained:
                break
            members = members - {weakest}
        return members

    def _left(self, members) -> float:
        """Residual sum of squares over the axes."""
        if not members:
            return float(self.energy.sum())
        index, theta, _, _ = self.solve(members)
        fitted = np.einsum("iab,a,b->i", self.gram[:, index[:, None], index], theta, theta)
        return float((self.energy - 2.0 * self.cross[:, index] @ theta + fitted).sum())

    def _beam(self, allowed, width: int = 4, depth: int = 4) -> frozenset:
        beam, best = [frozenset()], frozenset()
        for _ in range(depth):
            longer = {members | {k} for members in beam for k in allowed if self._fits(members, k)}
            beam = sorted(longer, key=self.score)[:width]
            if not beam or self.score(beam[0]) >= self.score(best):
                break
            best = beam[0]
        return best

    def _fits(self, members, k) -> bool:
        name = self.terms[k].name
        return all(self.terms[j].name != name for j in members)

    def _climb(self, members: frozenset, allowed, locked: frozenset = frozenset()) -> frozenset:
        while True:
            moves = [members - {k} for k in members - locked]
            if len(members) < _MAX_TERMS:
                new = [k for k in allowed if self._fits(members, k) and not (locked and self.terms[k].is_physical)]
                moves += [members | {k} for k in self._promising(members, new)]
            best = min(moves, key=self.score, default=members)
            if self.score(best) >= self.score(members):
                return members
            members = best

    def _exchange(self, members: frozenset, allowed) -> frozenset:
        while True:
            moves = []
            for j in members:
                rest = members - {j}
                moves += [rest | {k} for k in self._promising(rest, allowed) if k != j and self._fits(rest, k)]
            best = min(moves, key=self.score, default=members)
            if self.score(best) >= self.score(members):
                return members
            members = self._climb(best, allowed)

    def _promising(self, members: frozenset, candidates) -> list[int]:
        """The candidates that would lower the residual most for their cost, by the Schur complement of the Gram matrix:
        one inverse for all of them, where an exact score would need one each.
        """
        inside = np.concatenate([self.place[k] for k in sorted(members)]).astype(int) if members else np.zeros(0, int)
        inverse, _ = _pseudo_inverse(self.normed_gram[np.ix_(inside, inside)])
        away = inverse @ self.normed_gram[inside]
        left = self.normed_cross - away.T @ self.normed_cross[inside]
        unit = self._left(members) / max(float(self.m @ self.variance), 1e-300)

        def gain(k):
            own = self.place[k]
            schur = self.normed_gram[np.ix_(own, own)] - self.normed_gram[np.ix_(own, inside)] @ away[:, own]
            inverse, rank = _pseudo_inverse(schur)
            return left[own] @ inverse @ left[own] / unit - rank * np.log(self.m.sum()) - self.terms[k].price

        return sorted(candidates, key=gain, reverse=True)[:_PROMISING]

    def prune(self, members: frozenset) -> frozenset:
        """Drop the axes (harmonics) of an effect that the data does not support; the effect keeps one at least."""
        for k in sorted(k for k in members if self.terms[k].is_physical):
            current = k
            for group in self.terms[k].source.groups(self.terms[k].labels):
                term = self.terms[current]
                kept = tuple(label for label in term.labels if label not in group)
                if not kept or len(kept) == len(term.labels):
                    continue
                smaller = (members - {current}) | {self._part(current, kept)}
                if self.score(smaller) <= self.score(members) + _SAME_SCORE:
                    members, current = smaller, len(self.terms) - 1
        return members

    def _part(self, k: int, labels: tuple[str, ...]) -> int:
        term = self.terms[k]
        self.terms.append(Term(term.source, labels, term.shape))
        self.place.append(np.array([self.place[k][term.labels.index(label)] for label in labels]))
        return len(self.terms) - 1

    def alternatives(self, members: frozenset) -> list[list[str]]:
        """Sets of effect names that the data cannot tell apart, each with the named effect first."""
        if self.is_physics_whole:
            members = frozenset(k for k in members if self.terms[k].is_physical)
        own = self.score(members)
        physical = [k for k, term in enumerate(self.terms) if term.is_physical]
        found: dict[str, list[str]] = {}
        for j in sorted(k for k in members if self.terms[k].is_physical):
            rest, name = members - {j}, self.terms[j].name
            rivals = [k for k in physical if self.terms[k].name != name and self._fits(rest, k)]
            close = [(self.score(rest | {k}), (k,)) for k in rivals]
            close += [
                (self.score(rest | {k, h}), (k, h)) for a, k in enumerate(rivals) for h in rivals[a + 1 :]
                if _is_simple(self.terms[k]) and _is_simple(self.terms[h]) and self.terms[k].name != self.terms[h].name
            ]  # fmt: skip
            near = [pair for score, pair in sorted(close) if score < own + TOLERANCE + PHYSICAL_PRICE * (len(pair) - 1)]
            others = list(dict.fromkeys(self.terms[k].name for pair in near for k in pair))
            if others:
                found.setdefault(name, [name]).extend(o for o in others if o not in found[name])
        return list(found.values())


def _pseudo_inverse(gram: np.ndarray) -> tuple[np.ndarray, int]:
    """Inverse within the span of the well-determined directions, and their number."""
    if not gram.size:
        return gram, 0
    values, vectors = np.linalg.eigh(gram)
    keep = values > _SINGULAR * max(values[-1], 1.0)
    return (vectors[:, keep] / values[keep]) @ vectors[:, keep].T, int(keep.sum())


def _is_simple(term: Term) -> bool:
    return term.name in ("coulomb_friction", "current_offset", "viscous_friction", "thrust_constant", "cable_spring")
