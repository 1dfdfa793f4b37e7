"""What each entry of a fit explains of the held-out residual r, and what several explain together.

    unique_e  = (|left without e|^2 - |left|^2)/|r|^2, the others fitted again in the training: what none of them can
                take over
    joint     = 1 - |left|^2/|r|^2 - sum of unique_e: what several can, each in the place of another; below zero
                where they explain together more than each alone

as in commonality analysis (Newton and Spurrell, 1967), so that unique shares, joint share and what is left add up to
one. To first order: the entries stay in the span of their derivatives.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.diagnosis.fit import Entry, Fit
from gravcomp.diagnosis.search.gram import pseudo_inverse
from gravcomp.diagnosis.thresholds import TINY
from gravcomp.logs.measurement import Measurement


@dataclass(frozen=True)
class Shares:
    """Of the square sum before, each at least 0: unique by the name of an entry, what all corrections explain beside
    the effects, what is left.
    """

    unique: dict[str, float]
    of_corrections: float
    left: float

    @property
    def joint(self) -> float:
        return 1.0 - self.left - sum(self.unique.values())


def shares(data: Measurement, fit: Fit, weight, use, before, after) -> Shares:
    """weight (n, k): of samples in the training, zero elsewhere; use (n, k): held-out samples; before, after (n, k)."""
    total, left = max(np.sum(before[use] ** 2), TINY), np.sum(after[use] ** 2)
    span = _Span(data, fit.entries, weight)

    def only(own: list[Entry]) -> float:
        energy = np.sum((after + span.beside_others(own))[use] ** 2)
        return float(np.clip((energy - left) / total, 0.0, 1.0))

    by_name: dict[str, list[Entry]] = {}
    for entry in fit.entries:
        by_name.setdefault(entry.name, []).append(entry)
    of_corrections = only(list(fit.corrections)) if fit.corrections else 0.0
    return Shares({name: only(own) for name, own in by_name.items()}, of_corrections, float(left / total))


class _Span:
    """Forces of the entries, and how near to each the others come on weighted samples."""

    def __init__(self, data: Measurement, entries: tuple[Entry, ...], weight: np.ndarray):
        self._entries = entries
        blocks = [_derivatives(data, entry) for entry in entries]
        ends = np.cumsum([0, *(block.shape[-1] for block in blocks)])
        self._place = {id(entry): np.arange(ends[k], ends[k + 1]) for k, entry in enumerate(entries)}
        self._force = {id(entry): data.once(entry.force) for entry in entries}
        columns = np.concatenate([*blocks, np.zeros((*data.shape, 0))], axis=-1)
        norm = np.sqrt(np.einsum("nka,nk->a", columns**2, weight**2))
        self._columns = columns / np.maximum(norm, TINY)
        self._weight = weight
        self._gram = np.einsum("nka,nkb,nk->ab", self._columns, self._columns, weight**2, optimize=True)

    def beside_others(self, own: list[Entry]) -> np.ndarray:
        """Force (n, k) of these entries less what the others can take over of it."""
        force = sum(self._force[id(entry)] for entry in own)
        others = [self._place[id(entry)] for entry in self._entries if not any(entry is one for one in own)]
        if not others:
            return force
        at = np.concatenate(others)
        inverse, _ = pseudo_inverse(self._gram[np.ix_(at, at)])
        theta = inverse @ np.einsum("nka,nk->a", self._columns[..., at], force * self._weight**2)
        return force - self._columns[..., at] @ theta


def _derivatives(data: Measurement, entry: Entry) -> np.ndarray:
    """(n, k, p)."""
    by_name = entry.term.candidate.jacobian(data, entry.parameters)
    return np.stack([by_name[name] for name in entry.parameters], axis=-1)


def along(data: Measurement, entry: Entry, use: np.ndarray, before: np.ndarray) -> np.ndarray:
    """<F_e, r> on the samples to use, per axis (k,): over all entries and what is left they add up to <r, r>."""
    return np.sum(np.where(use, data.once(entry.force) * before, 0.0), axis=0)
