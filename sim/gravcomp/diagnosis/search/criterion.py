"""The information criterion over sets of terms, the smaller the better.

score = sum over axes of m_i log(RSS_i / m_i) + rank log(sum m_i) + price of each term; m_i: samples of axis i that
count as independent. A price stands for the number of terms that were tried. What physics refuses is impossible.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, Term
from gravcomp.diagnosis.search.gram import Gram, Subset
from gravcomp.diagnosis.thresholds import CANCELLATION, IMPOSSIBLE, NEGATIVE_Z, TINY

Members = frozenset  # of numbers of terms


class Criterion:
    """Scores sets of terms. Terms are known by number; ``part`` adds those of fewer axes."""

    def __init__(self, terms: list[Term], gram: Gram, n_effects: int, known: Mapping[str, Mapping[str, float]]):
        """The first n_effects terms are effects, the others corrections; known: by effect the parameters that the model
        has.
        """
        self.known = known
        self.terms, self.gram, self.place = list(terms), gram, list(gram.place)
        self.effects, self.corrections = range(n_effects), range(n_effects, len(terms))
        self._floor = 1e-12 * np.maximum(gram.energy, TINY) / gram.independent
        self._whole = list(range(len(terms)))
        self._scores: dict[Members, float] = {}

    def index(self, members) -> np.ndarray:
        """Columns of a set."""
        return np.concatenate([self.place[k] for k in sorted(members)]).astype(int) if members else np.zeros(0, int)

    def score(self, members: Members) -> float:
        if members not in self._scores:
            self._scores[members] = self._score(members)
        return self._scores[members]

    def left(self, members: Members) -> float:
        """Residual sum of squares over the axes."""
        return float(self.left_by_axis(members).sum())

    def left_in_noise(self, members: Members) -> float:
        """The same with each axis in units of its noise: a wrist counts as much as a shoulder."""
        return float((self.left_by_axis(members) / np.maximum(self.gram.variance, TINY)).sum())

    def left_by_axis(self, members: Members) -> np.ndarray:
        """Residual sum of squares of each axis, (k,)."""
        columns = self.gram.of(self.index(members))
        return columns.left(columns.solve()[0])

    def effects_of(self, members: Members) -> Members:
        return frozenset(k for k in members if self._whole[k] in self.effects)

    def whole(self, k: int) -> int:
        """The number of the term that term k is a part of."""
        return self._whole[k]

    def part(self, k: int, labels: tuple[Parameter, ...]) -> int:
        """The number of a term that is term k with these of its labels only."""
        term = self.terms[k]
        for j, other in enumerate(self.terms):
            if self._whole[j] == self._whole[k] and other.labels == labels:
                return j
        self.terms.append(replace(term, labels=labels))
        self.place.append(np.array([self.place[k][term.labels.index(label)] for label in labels]))
        self._whole.append(self._whole[k])
        return len(self.terms) - 1

    def coefficients(self, members: Members) -> dict[int, tuple[int, np.ndarray]]:
        """By member: the number of the term that it is (a part of), and coefficients of all columns of that one."""
        index = self.index(members)
        theta = np.zeros(self.gram.cross.shape[1])
        theta[index] = self.gram.of(index).solve()[0]
        out = {}
        for k in members:
            own = np.zeros_like(theta)
            own[self.place[k]] = theta[self.place[k]]
            out[k] = (self._whole[k], own[self.place[self._whole[k]]])
        return out

    def _score(self, members: Members) -> float:
        gram, rss, rank = self.gram, self.gram.energy, 0
        if members:
            index = self.index(members)
            columns = gram.of(index)
            theta, covariance, rank = columns.solve()
            if any(self._refusals(members, index, theta, covariance)) or self._cancels(members, columns, theta):
                return IMPOSSIBLE
            rss = np.maximum(columns.left(theta), 0.0)
        m = gram.independent
        likelihood = np.sum(m * np.log(np.maximum(rss / m, self._floor)))
        return float(likelihood + rank * np.log(m.sum()) + sum(self.terms[k].candidate.price for k in members))

    def _cancels(self, members: Members, columns: Subset, theta: np.ndarray) -> bool:
        """Terms that are large only to cancel one another imitate something else."""
        if len(members) < 2:
            return False
        sizes = [len(self.place[k]) for k in sorted(members)]
        total, single = columns.energies(theta, np.cumsum([0, *sizes[:-1]]))
        return single > CANCELLATION * total

    def refused(self, members: Members) -> tuple[int, Parameter] | None:
        """A term of the set with a coefficient that physics refuses; None where there is none."""
        index = self.index(members)
        theta, covariance, _ = self.gram.of(index).solve()
        return next(self._refusals(members, index, theta, covariance), None)

    def _refusals(self, members: Members, index, theta, covariance) -> Iterator[tuple[int, Parameter]]:
        """Terms with a coefficient that physics makes positive and that is clearly negative even with what the model
        has, or with one that is too large.
        """
        position = {column: a for a, column in enumerate(index)}
        for k in members:
            labels, candidate = self.terms[k].labels, self.terms[k].candidate
            at = {label: position[column] for label, column in zip(labels, self.place[k], strict=True)}
            for contrast in candidate.contrasts(labels):
                c, allowed = np.zeros(len(index)), 0.0
                for label, factor in contrast.items():
                    if label in at:
                        c[at[label]] = factor
                        allowed += factor * candidate.allowance(label, self.known)
                if c @ theta + max(allowed, 0.0) < -NEGATIVE_Z * np.sqrt(max(c @ covariance @ c, TINY)):
                    yield k, next(iter(contrast))
            for label in labels:
                if np.isfinite(self.terms[k].limit(label)):
                    error = np.sqrt(max(covariance[at[label], at[label]], TINY))
                    if abs(theta[at[label]]) > self.terms[k].limit(label) + NEGATIVE_Z * error:
                        yield k, label
