"""Moves through the sets of terms to one of a low score: a beam from nothing, then single changes while they help."""

import numpy as np

from gravcomp.diagnosis.search.criterion import Criterion, Members
from gravcomp.diagnosis.thresholds import (
    BEAM_DEPTH,
    BEAM_WIDTH,
    IMPOSSIBLE,
    MAX_TERMS,
    PROMISING,
    REFUSED,
    TINY,
)

EMPTY: Members = frozenset()


def fits(criterion: Criterion, members: Members, k: int) -> bool:
    """A name stands once in a set."""
    name = criterion.terms[k].name
    return all(criterion.terms[j].name != name for j in members)


def beam(criterion: Criterion, allowed) -> Members:
    """The best set within a few terms."""
    sets, best = [EMPTY], EMPTY
    for _ in range(BEAM_DEPTH):
        longer = {members | {k} for members in sets for k in allowed if fits(criterion, members, k)}
        sets = sorted(longer, key=criterion.score)[:BEAM_WIDTH]
        if not sets or criterion.score(sets[0]) >= criterion.score(best):
            break
        best = sets[0]
    return best


def climb(criterion: Criterion, members: Members, allowed, locked: Members = EMPTY) -> Members:
    """Add or drop one term while that lowers the score; locked ones stay."""
    while True:
        moves = [members - {k} for k in members - locked]
        if len(members) < MAX_TERMS:
            moves += additions(criterion, members, allowed)
        best = min(moves, key=criterion.score, default=members)
        if criterion.score(best) >= criterion.score(members):
            return members
        members = best


def exchange(criterion: Criterion, members: Members, allowed) -> Members:
    """Put one term in another's place while that lowers the score."""
    while True:
        moves = []
        for j in members:
            moves += additions(criterion, members - {j}, [k for k in allowed if k != j])
        best = min(moves, key=criterion.score, default=members)
        if criterion.score(best) >= criterion.score(members):
            return members
        members = climb(criterion, best, allowed)


def additions(criterion: Criterion, members: Members, candidates) -> list[Members]:
    """The set with one candidate more: those that would lower the residual most for their cost, where an exact score
    would need one each. Where physics refuses all of them the next have their turn.
    """
    gram, candidates = criterion.gram, [k for k in candidates if fits(criterion, members, k)]
    m, left = gram.independent, criterion.left(members)
    if left <= 0.0:
        return []
    unit = left / max(float(m @ gram.variance), TINY)
    gains = gram.gains(criterion.index(members), [criterion.place[k] for k in candidates])
    worth = {
        k: gain / unit - rank * np.log(m.sum()) - criterion.terms[k].candidate.price
        for k, (gain, rank) in zip(candidates, gains, strict=True)
    }
    ranked = sorted(candidates, key=worth.get, reverse=True)[:REFUSED]
    for first in range(0, len(ranked), PROMISING):
        moves = [members | {k} for k in ranked[first : first + PROMISING]]
        possible = [move for move in moves if criterion.score(move) < IMPOSSIBLE]
        if possible:
            return possible
    return []
