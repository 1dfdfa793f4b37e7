"""What the criterion alone does not say: which set to name, when physics is the whole story, what is ambiguous."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from gravcomp.diagnosis.search.criterion import Criterion, Members
from gravcomp.diagnosis.search.search import EMPTY, additions, beam, climb, exchange, fits
from gravcomp.diagnosis.thresholds import (
    AS_A_TABLE,
    BESIDE_CORRECTION,
    FORM_LEFT,
    IMPOSSIBLE,
    MISSED,
    NAMED_BESIDE,
    NOISE_AT_LEAST,
    PHYSICAL_PRICE,
    REMAINDER,
    SAME_SCORE,
    TIE,
    TINY,
    TRIFLE,
    TRIFLE_LEFT,
    VAGUE,
)


@dataclass(frozen=True)
class Choice:
    """A set of terms; is_physics_whole: its effects miss next to nothing of what can be explained at all."""

    members: Members
    is_physics_whole: bool


def choose(criterion: Criterion) -> Choice:
    """The best set. Physics that misses next to nothing of what can be explained at all stays whole, and
    corrections may only come on top of it; otherwise effects and corrections compete freely. A name that a single
    correction beats is not in the competition.
    """
    allowed = list(criterion.effects)
    effects = _named(criterion, allowed)
    while beaten := _beaten(criterion, effects):
        allowed = _without(criterion, allowed, beaten)
        effects = _named(criterion, allowed)
    every = [*allowed, *criterion.corrections]
    free = min((climb(criterion, start, every) for start in {EMPTY, effects}), key=criterion.score)
    free = exchange(criterion, free, every)
    if effects and _is_whole(criterion, effects, free):
        return Choice(climb(criterion, effects, criterion.corrections, locked=effects), True)
    if free - criterion.effects_of(free):
        free = _substantial(criterion, free, BESIDE_CORRECTION)
        free = _unambiguous(criterion, climb(criterion, free, criterion.corrections, locked=free))
        free = climb(criterion, free, criterion.corrections, locked=free)
    return Choice(_pruned(criterion, free), False)


def _is_whole(criterion: Criterion, effects: Members, best: Members) -> bool:
    """Do these effects miss next to nothing of what the best set explains?"""
    left = criterion.left(best)
    return criterion.left(effects) - left < MISSED * (criterion.left(EMPTY) - left)


def _named(criterion: Criterion, allowed) -> Members:
    """The best set of effects alone."""
    effects = exchange(criterion, beam(criterion, allowed), allowed)
    effects = _simpler_axes(criterion, _simplest(criterion, effects))
    return _pruned(criterion, _by_direction(criterion, _trifles_dropped(criterion, effects)))


def _beaten(criterion: Criterion, effects: Members) -> set[tuple[str, int]]:
    """Names and axes on which, in the place of the name, a single correction of that axis clearly shows more evidence.

    Only a name with as many coefficients on the axis as a table is asked, and names together that follow the same
    position there: few coefficients are what speaks for a name, and what several have together is as free as a table.
    """
    out, own = set(), criterion.score(effects)
    for names in _as_a_table(criterion, effects):
        rest = frozenset(_without(criterion, effects, names))
        (axis,) = {axis for _, axis in names}
        there = [j for j in criterion.corrections if criterion.terms[j].candidate.axis == axis]
        others = additions(criterion, rest, there)
        if min(map(criterion.score, others), default=own) < own - TIE:
            out |= names
    return out


def _as_a_table(criterion: Criterion, effects: Members) -> list[set[tuple[str, int]]]:
    """Names on an axis, alone or as all that follow its position, with as many coefficients there as a table."""
    alone, together, size = [], {}, Counter()
    for k in sorted(effects):
        term = criterion.terms[k]
        for axis, own in Counter(label.axis for label in term.labels if label.axis is not None).items():
            if own >= AS_A_TABLE:
                alone.append({(term.name, axis)})
            if term.candidate.is_of_own_position:
                together.setdefault(axis, set()).add((term.name, axis))
                size[axis] += own
    return alone + [names for axis, names in together.items() if len(names) > 1 and size[axis] >= AS_A_TABLE]


def _without(criterion: Criterion, terms, beaten: set[tuple[str, int]]) -> list[int]:
    """The terms, each with the labels that are left of it where a name is not to stand on an axis."""
    out = []
    for k in terms:
        name, labels = criterion.terms[k].name, criterion.terms[k].labels
        kept = tuple(label for label in labels if (name, label.axis) not in beaten)
        if kept:
            out.append(k if kept == labels else criterion.part(k, kept))
    return out


def certain(criterion: Criterion, choice: Choice, noise: np.ndarray, imitable: Mapping[str, np.ndarray]) -> Choice:
    """The choice without names that could imitate a part of what no name accounts for.

    noise (k,): what no model made. Where effects leave more than REMAINDER times that, each has to account for
    NAMED_BESIDE times what they leave of it, beside the other effects; the weakest goes first, and before all others
    those with as many coefficients on an axis as a table. An effect of single axes is asked on each of them: what is
    unknown of a shoulder is no doubt about a wrist. imitable (k,), by name: the part of what all effects leave that the
    effect could be a part of at all; a friction is no part of what is the same both ways. Of what names leave that are
    withdrawn nothing like it is known: it counts whole.
    """
    members, floor = choice.members, criterion.gram.independent * np.square(noise)
    first = criterion.left_by_axis(criterion.effects_of(members))
    while effects := criterion.effects_of(members):
        left = criterion.left_by_axis(effects)
        if np.maximum(left - floor, 0.0).sum() < (REMAINDER**2 - 1.0) * floor.sum():
            break
        every, doubts = np.ones(len(floor)), []
        for k in sorted(effects):
            like_it = imitable.get(criterion.terms[k].name, every)
            doubts += _doubts(criterion, effects, k, left - first + first * like_it, floor * like_it)
        weak = [own for own in doubts if own.worth < 1.0]
        if not weak:
            break
        weakest = min(weak, key=lambda own: (not own.is_of_table, own.worth))
        members = (members - effects) | weakest.without
    if members == choice.members:
        return choice
    effects = _possible(criterion, criterion.effects_of(members))
    members = (members - criterion.effects_of(members)) | effects
    members = climb(criterion, members, criterion.corrections, locked=effects)
    return Choice(members, choice.is_physics_whole and _is_whole(criterion, effects, members))


@dataclass(frozen=True)
class _Doubt:
    """What a name accounts for, whole or on an axis, in parts of what it must; the effects that stay without it;
    is_of_table: it has as many coefficients there as a table.
    """

    worth: float
    without: Members
    is_of_table: bool = False


def _doubts(criterion: Criterion, effects: Members, k: int, left: np.ndarray, floor: np.ndarray) -> list[_Doubt]:
    """What effect k accounts for beside the others. The whole must account for NAMED_BESIDE times what is unnamed.

    Of an effect of single axes each axis where anything is: it must do the same there where the whole does not, or
    where it has as many coefficients there as a table, which imitate much: the noise may be as low as its estimate is
    sure to be then, and what a name of the whole machine lost to it that has again. Else it must account for as much as
    is unnamed. left, floor (k,): of what it could be a part of.
    """
    term, own, unnamed = criterion.terms[k], criterion.left(effects), np.maximum(left - floor, 0.0)
    whole = (criterion.left(effects - {k}) - own) / max(unnamed.sum(), TINY) / NAMED_BESIDE
    axes = Counter(label.axis for label in term.labels) if term.candidate.is_by_axis else {}
    if not axes:
        return [_Doubt(whole, effects - {k})]
    out = []
    for axis, size in axes.items():
        kept = tuple(label for label in term.labels if label.axis != axis)
        is_table = size >= AS_A_TABLE
        others = _restored(criterion, effects - {k}) if is_table else effects - {k}
        fewer = others | ({criterion.part(k, kept)} if kept else EMPTY)
        there = left[axis] - NOISE_AT_LEAST**2 * floor[axis] if is_table else unnamed[axis]
        if there > (REMAINDER**2 - 1.0) * floor[axis] or (is_table and there > 0.0):
            least = 1.0 if whole >= 1.0 and not is_table else NAMED_BESIDE
            accounted = criterion.left(fewer) - criterion.left(others | {k})
            out.append(_Doubt(accounted / there / least, fewer, is_table))
    return out


def _possible(criterion: Criterion, effects: Members) -> Members:
    """The effects without those, of single axes without these, that physics refuses where others were withdrawn."""
    while effects and (refused := criterion.refused(effects)):
        k, label = refused
        kept = tuple(own for own in criterion.terms[k].labels if own.axis != label.axis)
        is_part = kept and criterion.terms[k].candidate.is_by_axis
        effects = (effects - {k}) | ({criterion.part(k, kept)} if is_part else EMPTY)
    return effects


def _restored(criterion: Criterion, effects: Members) -> Members:
    """The effects, those of the whole machine with all their labels."""
    whole = {k: criterion.whole(k) for k in effects}
    return frozenset(k if criterion.terms[k].candidate.is_by_axis else j for k, j in whole.items())


def alternatives(criterion: Criterion, choice: Choice) -> list[list[str]]:
    """Sets of effect names that the data cannot tell apart, each with the named effect first.

    Two that stand for one count where neither does so alone; a more general form of what is as good counts where the
    data leave room for it.
    """
    members = criterion.effects_of(choice.members) if choice.is_physics_whole else choice.members
    out: dict[str, list[str]] = {}
    for j, near in _rivals(criterion, members):
        alone = {pair[0] for pair in near if len(pair) == 1}
        kept = [pair for pair in near if len(pair) == 1 or not alone & {*pair}]
        kept = [pair for pair in kept if len(pair) > 1 or _has_room(criterion, members, j, pair[0])]
        _add_names(out, criterion, j, kept)
    return list(out.values())


def _rivals(criterion: Criterion, members: Members) -> list[tuple[int, list[tuple[int, ...]]]]:
    """By effect of the set the terms, alone or two together, that would be as good in its place, the best first."""
    own, terms, out = criterion.score(members), criterion.terms, []
    if own >= IMPOSSIBLE:  # what is left of a set after names were withdrawn may be refused: it has no rivals then
        return []
    for j in sorted(criterion.effects_of(members)):
        rest, name = members - {j}, terms[j].name
        rivals = [k for k in criterion.effects if terms[k].name != name and fits(criterion, rest, k)]
        close = [(criterion.score(rest | {k}), (k,)) for k in rivals]
        simple = [k for k in rivals if terms[k].candidate.is_simple]
        close += [
            (criterion.score(rest | {k, h}), (k, h))
            for a, k in enumerate(simple)
            for h in simple[a + 1 :]
            if terms[k].name != terms[h].name
        ]
        near = [pair for score, pair in sorted(close) if score < own + TIE + PHYSICAL_PRICE * (len(pair) - 1)]
        out.append((j, near))
    return out


def _add_names(out: dict[str, list[str]], criterion: Criterion, j: int, near: list[tuple[int, ...]]) -> None:
    """The names of near terms behind that of term j, none twice; nothing where there are none."""
    name = criterion.terms[j].name
    others = list(dict.fromkeys(criterion.terms[k].name for pair in near for k in pair))
    if others:
        out.setdefault(name, [name]).extend(other for other in others if other not in out[name])


def _has_room(criterion: Criterion, members: Members, j: int, k: int) -> bool:
    """Does this data leave room for term k, where its special case is as good in the place of term j, to be more?

    What it adds may be a trifle at most, of 95 % confidence: then k is its special case, and no rival of its own.
    """
    terms, rest = criterion.terms, members - {j}
    special = [s for s in criterion.effects if terms[s].name == terms[k].candidate.special_case]
    special = (
        [j] if terms[j].name == terms[k].candidate.special_case else [s for s in special if fits(criterion, rest, s)]
    )
    best = min((rest | {s} for s in special), key=criterion.score, default=None)
    if best is None or criterion.score(best) > criterion.score(members) + TIE:
        return True
    left = criterion.left(best)
    variance = left / max(float(criterion.gram.independent.sum()), TINY)
    gain = max(left - criterion.left(rest | {k}), 0.0)
    more = max(len(terms[k].labels) - sum(len(terms[s].labels) for s in best - rest), 1)
    most = (np.sqrt(gain) + 2.0 * np.sqrt(more * variance)) ** 2
    return bool(most >= TRIFLE * (criterion.left(rest) - left))


def _simplest(criterion: Criterion, members: Members) -> Members:
    """Use the special case of an effect (Coulomb for Stribeck) where the general one gains next to nothing."""
    for k in sorted(members):
        special, rest = criterion.terms[k].candidate.special_case, members - {k}
        options = [j for j in criterion.effects if criterion.terms[j].name == special and fits(criterion, rest, j)]
        if not options:
            continue
        best = rest | {min(options, key=lambda j: criterion.score(rest | {j}))}
        if _is_trifle(criterion, best, members, FORM_LEFT):
            members = best
    return members


def _is_trifle(criterion: Criterion, fewer: Members, members: Members, of_left: float = TRIFLE_LEFT) -> bool:
    """Does the set explain next to nothing more than the smaller one, beside all that it explains and all it leaves?"""
    left = criterion.left_in_noise(members)
    lost, explained = criterion.left_in_noise(fewer) - left, criterion.left_in_noise(EMPTY) - left
    return criterion.score(fewer) < IMPOSSIBLE and lost < min(TRIFLE * explained, of_left * left)


def _simpler_axes(criterion: Criterion, members: Members) -> Members:
    """On each axis by itself: simple effects, or its special case there alone, in the place of a general one that gains
    next to nothing there.
    """
    simple = [k for k in criterion.effects if criterion.terms[k].candidate.is_simple]
    general = [k for k in members if criterion.terms[k].candidate.special_case]
    for k in sorted(general):
        axes = sorted({label.axis for label in criterion.terms[k].labels} - {None})
        for axis in axes:
            labels = criterion.terms[k].labels
            kept = tuple(label for label in labels if label.axis != axis)
            if not kept:
                break
            part = criterion.part(k, kept)
            rest = (members - {k}) | {part}
            fewer = min((climb(criterion, rest, simple), *_specially(criterion, rest, k, axis)), key=criterion.score)
            is_as_good = criterion.score(fewer) <= criterion.score(members) + TIE
            if is_as_good and _is_trifle(criterion, fewer, members):
                members, k = fewer, part
    return members


def _specially(criterion: Criterion, members: Members, k: int, axis: int) -> Iterator[Members]:
    """The set with the special case of effect k on an axis, beside the axes on which the set has that already."""
    name = criterion.terms[k].candidate.special_case
    present = {j for j in members if criterion.terms[j].name == name}
    for whole in (j for j in criterion.effects if criterion.terms[j].name == name):
        if all(criterion.whole(j) == whole for j in present):
            axes = {axis, *(label.axis for j in present for label in criterion.terms[j].labels)}
            labels = tuple(label for label in criterion.terms[whole].labels if label.axis in axes)
            if labels:
                yield (members - present) | {criterion.part(whole, labels)}


def _by_direction(criterion: Criterion, members: Members) -> Members:
    """Where one friction differs by direction, the one that goes with it may too."""
    terms = criterion.terms
    is_directional = {k: terms[k].candidate.is_directional(terms[k].labels) for k in {*members, *criterion.effects}}
    for k in [k for k in members if is_directional[k]]:
        partner = next((j for j in members if terms[j].name == terms[k].candidate.differs_with), None)
        if partner is not None:
            rest = members - {partner}
            both = [j for j in criterion.effects if terms[j].name == terms[partner].name and is_directional[j]]
            members = min((rest | {j} for j in both), key=criterion.score, default=members)
    return members


def _substantial(criterion: Criterion, members: Members, least: float) -> Members:
    """Drop effects, the weakest first, that alone account for less than a part of what the set explains."""
    while effects := criterion.effects_of(members):
        if len(members) == 1:
            break
        explained = criterion.left(EMPTY) - criterion.left(members)
        lost = {k: criterion.left(members - {k}) - criterion.left(members) for k in effects}
        weakest = min(lost, key=lost.get)
        if lost[weakest] >= least * explained:
            break
        members = members - {weakest}
    return members


def _trifles_dropped(criterion: Criterion, members: Members) -> Members:
    """Drop effects, the weakest first, that are next to nothing beside what is explained and beside what is left."""
    while len(members) > 1:
        fewer = [members - {k} for k in criterion.effects_of(members)]
        trifles = [rest for rest in fewer if _is_trifle(criterion, rest, members)]
        if not trifles:
            break
        members = min(trifles, key=criterion.left_in_noise)
    return members


def _unambiguous(criterion: Criterion, members: Members) -> Members:
    """Beside corrections, a name that many others could take as well says nothing: drop it.

    An effect that contains the named one, as Stribeck's friction does Coulomb's, is no other explanation.
    """
    found: dict[str, list[str]] = {}
    for j, near in _rivals(criterion, members):
        _add_names(found, criterion, j, [pair for pair in near if not _contain(criterion, pair, j)])
    vague = {names[0] for names in found.values() if len(names) > VAGUE}
    effects = criterion.effects_of(members)
    return frozenset(k for k in members if not (k in effects and criterion.terms[k].name in vague))


def _contain(criterion: Criterion, others: tuple[int, ...], j: int) -> bool:
    """Do all columns of term j lie in the span of the others'?"""
    return criterion.gram.gains(criterion.index(others), [criterion.place[j]])[0][1] == 0


def _pruned(criterion: Criterion, members: Members) -> Members:
    """Drop the axes (harmonics) of effects that the data does not support, those first that cost most for what they
    explain; an effect keeps one at least. What two effects share stays with the more usual one.
    """
    while fewer := list(_without_a_group(criterion, members)):
        least = min(score for score, _, _ in fewer)
        if least > criterion.score(members) + SAME_SCORE:
            break
        _, _, members = min((own for own in fewer if own[0] <= least + SAME_SCORE), key=lambda own: own[1])
    return members


def _without_a_group(criterion: Criterion, members: Members) -> Iterator[tuple[float, tuple[float, int], Members]]:
    """Sets with a group of labels less: score, rank of the effect (the less usual first), members."""
    for k in members:
        candidate, labels = criterion.terms[k].candidate, criterion.terms[k].labels
        for group in candidate.groups(labels):
            kept = tuple(label for label in labels if label not in group)
            if 0 < len(kept) < len(labels):
                smaller = (members - {k}) | {criterion.part(k, kept)}
                yield criterion.score(smaller), (-candidate.price, k), smaller
