"""Names beside what has none: a small effect keeps its name beside noise, and loses it beside more of the unknown."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Candidate, Parameter, Regressor, Term
from gravcomp.diagnosis.search.criterion import Criterion
from gravcomp.diagnosis.search.gram import Gram
from gravcomp.diagnosis.search.rules import Choice, _beaten, _possible, _pruned, _simpler_axes, _without, certain
from gravcomp.diagnosis.search.search import climb

N, NOISE = 400, 0.1


class Named(Candidate):
    name, price = "named", 8.0


class Weak(Named):
    name = "weak"


class Nameless(Candidate):
    name, price = "nameless", 20.0


def certain_of(effect: float, unknown: float, weak: float = 0.0, imitable: float = 1.0) -> tuple[set[str], bool]:
    """What stays of two effects and one correction whose forces have these sizes, in units of the noise, that were
    said to be the whole story; and whether they still are.
    """
    rng = np.random.default_rng(4)
    columns = rng.standard_normal((3, N, 1))
    sizes = np.array([effect, weak, unknown])
    force = NOISE * (np.tensordot(sizes, columns, 1) + rng.standard_normal((N, 1)))
    terms = [
        Regressor(Term(kind(), (Parameter("x"),)), (own,))
        for kind, own in zip((Named, Weak, Nameless), columns, strict=True)
    ]
    gram = Gram(terms, force, np.ones((N, 1)), np.array([NOISE**2]), np.array([float(N)]))
    criterion = Criterion([own.term for own in terms], gram, 2, {})
    members = frozenset({0, 1, 2} if weak else {0, 2})
    choice = certain(criterion, Choice(members, True), np.array([NOISE]), {"named": np.array([imitable])})
    return {criterion.terms[k].name for k in choice.members}, choice.is_physics_whole


@pytest.mark.parametrize(("effect", "unknown", "stays"), [
    (1.0, 0.3, True),  # what the name leaves is no more than noise
    (4.0, 2.0, True),  # 16 against 4: four times
    (2.0, 2.0, False),  # as much unknown as named
    (0.5, 2.0, False),
])  # fmt: skip
def test_name_needs_three_times_what_no_name_accounts_for(effect, unknown, stays):
    found, _ = certain_of(effect, unknown)
    assert ("named" in found) == stays
    assert "nameless" in found


@pytest.mark.parametrize(("effect", "is_whole"), [(40.0, True), (10.0, False)])
def test_physics_stays_the_whole_story_without_a_weak_name_only_where_it_misses_next_to_nothing(effect, is_whole):
    """What is unknown is 0.25 % of what can be explained, or 4 %."""
    assert certain_of(effect, 2.0, weak=0.5) == ({"named", "nameless"}, is_whole)


def test_what_a_withdrawn_name_leaves_counts_whole():
    """4.8 against a tenth of 4; with a weak name's 2.2 beside it, it is less than three times as much."""
    assert "named" in certain_of(2.2, 2.0, imitable=0.1)[0]
    assert certain_of(2.2, 2.0, weak=1.5, imitable=0.1)[0] == {"nameless"}


class ByAxis(Named):
    name, is_by_axis = "by axis", True


def axes_kept(sizes, unknown: float, imitable: float = 1.0, width: int = 1) -> set[int]:
    """Axes of a name that is in the data with these sizes on two of them, in units of the noise, beside what has no
    name on the first; width: coefficients on each axis.
    """
    rng = np.random.default_rng(8)
    own, other, noise = (rng.standard_normal((N, size)) for size in (2 * width, 1, 2))
    parts = np.c_[own[:, :width].sum(axis=1), own[:, width:].sum(axis=1)] / np.sqrt(width)
    force = NOISE * (parts * sizes + np.c_[unknown * other, 0.0 * other] + noise)
    labels = tuple(Parameter(f"x{k}", axis) for axis in (0, 1) for k in range(width))
    zero = np.zeros((N, width))
    terms = [
        Regressor(Term(ByAxis(), labels), (np.c_[own[:, :width], zero], np.c_[zero, own[:, width:]])),
        Regressor(Term(Nameless(), (Parameter("y"),)), (other, None)),
    ]
    gram = Gram(terms, force, np.ones((N, 2)), np.full(2, NOISE**2), np.full(2, float(N)))
    criterion = Criterion([own.term for own in terms], gram, 1, {})
    part = {"by axis": np.array([imitable, 1.0])}
    choice = certain(criterion, Choice(frozenset({0, 1}), False), np.full(2, NOISE), part)
    return {label.axis for k in criterion.effects_of(choice.members) for label in criterion.terms[k].labels}


@pytest.mark.parametrize(("sizes", "unknown", "kept"), [
    ((1.0, 4.0), 3.0, {1}),  # 17 against 9 as a whole; 1 against 9 on axis 1, where alone something has no name
    ((3.0, 4.0), 2.5, {0, 1}),  # 25 against 6.2: four times, and more than once on axis 1
    ((1.5, 8.0), 2.5, {1}),  # eleven times, but on axis 1 a third of what has no name there
])  # fmt: skip
def test_name_is_asked_on_each_axis_and_for_more_where_it_is_weak_as_a_whole(sizes, unknown, kept):
    """Sizes on two axes, and what has no name on axis 1, in units of the noise."""
    assert axes_kept(sizes, unknown) == kept


def test_name_is_asked_beside_what_it_could_be_a_part_of_alone():
    """2.2 against 9, of which a tenth goes with the direction."""
    assert axes_kept((1.5, 4.0), 3.0) == {1}
    assert axes_kept((1.5, 4.0), 3.0, imitable=0.1) == {0, 1}


@pytest.mark.parametrize(("width", "kept"), [(1, {0, 1}), (4, {1})])
def test_name_with_as_many_coefficients_as_a_table_has_to_hold_on_every_axis(width, kept):
    """9 against 6.2 on axis 1, where the noise may be as low as its estimate is sure to be; twenty times as a whole."""
    assert axes_kept((3.0, 10.0), 2.5, width=width) == kept


class Fragile(Nameless):
    """Refused by physics: its one coefficient can only be positive."""

    name = "fragile"

    def contrasts(self, labels):
        return [{label: 1.0} for label in labels]


def test_candidates_that_physics_refuses_leave_their_place_to_the_next():
    """Thirty columns that fit better, all with a sign that they cannot have, before the one that helps."""
    rng = np.random.default_rng(9)
    x = rng.standard_normal((N, 1))
    refused = [Regressor(Term(Fragile(), (Parameter("x"),)), (-x + 0.01 * rng.standard_normal((N, 1)),))
               for _ in range(30)]  # fmt: skip
    helps = Regressor(Term(Nameless(), (Parameter("y"),)), (x + 0.3 * rng.standard_normal((N, 1)),))
    force = x + NOISE * rng.standard_normal((N, 1))
    gram = Gram([*refused, helps], force, np.ones((N, 1)), np.array([NOISE**2]), np.array([float(N)]))
    criterion = Criterion([own.term for own in (*refused, helps)], gram, 0, {})
    assert climb(criterion, frozenset(), criterion.corrections) == {30}


def test_nothing_is_added_where_nothing_counts_any_more():
    """Every sample with weight zero, as where no direction is sure: nothing is left to explain."""
    x = np.random.default_rng(3).standard_normal((N, 1))
    term = Regressor(Term(Nameless(), (Parameter("y"),)), (x,))
    gram = Gram([term], x, np.zeros((N, 1)), np.array([NOISE**2]), np.array([2.0]))
    criterion = Criterion([term.term], gram, 0, {})
    assert climb(criterion, frozenset(), criterion.corrections) == frozenset()


class Simple(Candidate):
    name, price, is_simple = "simple", 8.0, True


class General(Candidate):
    name, price, special_case = "general", 8.0, "simple"


def axes_of_general(more: float) -> set[int]:
    """Axes that keep the general form, of two, where the special case leaves ``more`` of the noise's energy, in units
    of one sample's, on the second.
    """
    rng, n = np.random.default_rng(6), 2000
    simple, rest, other, noise = rng.standard_normal((4, n))
    general = np.column_stack([other, simple + np.sqrt(more / n) / 20.0 * rest])
    force = NOISE * (20.0 * general + np.column_stack([noise, rng.standard_normal(n)]))
    x = [Parameter("x", axis) for axis in range(2)]
    own = (general[:, [0]], general[:, [1]])
    columns = [np.column_stack([c, 0 * c]) if a == 0 else np.column_stack([0 * c, c]) for a, c in enumerate(own)]
    terms = [
        Regressor(Term(General(), tuple(x)), (columns[0], columns[1])),
        Regressor(Term(Simple(), (Parameter("s", 1),)), (None, simple[:, None])),
    ]
    gram = Gram(terms, force, np.ones((n, 2)), np.full(2, NOISE**2), np.full(2, float(n)))
    criterion = Criterion([own.term for own in terms], gram, 2, {})
    members = _simpler_axes(criterion, frozenset({0}))
    return {label.axis for k in members for label in criterion.terms[k].labels if criterion.terms[k].name == "general"}


@pytest.mark.parametrize(("more", "axes"), [(0.0, {0}), (100.0, {0, 1})])
def test_simple_form_takes_an_axis_only_where_it_has_the_evidence(more, axes):
    """100 is 2.5 % of what is left and far below 0.5 % of what is explained, and odds of exp(40)."""
    assert axes_of_general(more) == axes


class Curve(Named):
    name = "curve"


class OfPosition(Named):
    """Two coefficients: fewer than a table."""

    is_of_own_position = True

    def __init__(self, name: str):
        self.name = name


@pytest.mark.parametrize(("is_of_own_position", "beaten"), [(True, {("a", 0), ("b", 0)}), (False, set())])
def test_names_that_follow_one_position_are_asked_together(is_of_own_position, beaten):
    """Four columns that together are nearly one correction, as a spring and a wave are a stop."""
    rng, n = np.random.default_rng(12), 500
    columns, noise = rng.standard_normal((n, 4)), rng.standard_normal((n, 1))
    whole = columns.sum(axis=1, keepdims=True) + 0.3 * rng.standard_normal((n, 1))
    names = [OfPosition(name) for name in "ab"]
    for own in names:
        own.is_of_own_position = is_of_own_position
    terms = [
        Regressor(Term(own, tuple(Parameter(f"x{a}", 0) for a in range(2))), (columns[:, 2 * k : 2 * k + 2],))
        for k, own in enumerate(names)
    ]
    terms.append(Regressor(Term(OfOneAxis(0), (Parameter("y"),)), (whole,)))
    gram = Gram(terms, whole + NOISE * noise, np.ones((n, 1)), np.full(1, NOISE**2), np.full(1, float(n)))
    criterion = Criterion([own.term for own in terms], gram, 2, {})
    assert _beaten(criterion, frozenset({0, 1})) == beaten


class OfOneAxis(Nameless):
    def __init__(self, axis: int):
        self.axis = axis


def test_name_gives_way_on_the_axis_where_a_correction_of_that_axis_shows_more_evidence():
    """The name is right on axis 2; on axis 1 it has a half of a force that one correction has whole. A force of axis 2
    that no name has is another matter.
    """
    rng, n = np.random.default_rng(7), 500
    curves, (half, more), noise = (rng.standard_normal((size, n)) for size in (8, 2, 2))
    curves[0] += half
    force = np.column_stack([2.0 * half, curves[4:].sum(axis=0) + more]) + NOISE * noise.T
    labels = tuple(Parameter(f"x{a}", axis) for axis in range(2) for a in range(4))
    zero = np.zeros((n, 4))
    terms = [
        Regressor(Term(Curve(), labels), (np.c_[curves[:4].T, zero], np.c_[zero, curves[4:].T])),
        Regressor(Term(OfOneAxis(0), (Parameter("y"),)), (half[:, None], None)),
        Regressor(Term(OfOneAxis(1), (Parameter("y"),)), (None, more[:, None])),
    ]
    gram = Gram(terms, force, np.ones((n, 2)), np.full(2, NOISE**2), np.full(2, float(n)))
    criterion = Criterion([own.term for own in terms], gram, 1, {})
    beaten = _beaten(criterion, frozenset({0}))
    assert beaten == {("curve", 0)}
    (left,) = _without(criterion, [0], beaten)
    assert criterion.terms[left].labels == labels[4:]
    assert _without(criterion, [0], {("curve", 0), ("curve", 1)}) == []


def machine_of_two_axes(terms: list[Regressor], force: np.ndarray, n_effects: int) -> Criterion:
    gram = Gram(terms, force, np.ones(force.shape), np.full(2, NOISE**2), np.full(2, float(len(force))))
    return Criterion([own.term for own in terms], gram, n_effects, {})


class Body(Named):
    """Of the whole machine: a coefficient for each of two bodies."""

    name = "body"

    def groups(self, labels):
        return [{label} for label in labels]


class Table(ByAxis):
    name = "table"

    def groups(self, labels):
        return [{label for label in labels if label.axis == axis} for axis in (0, 1)]


def bodies_and_tables(of_table: float) -> tuple[Criterion, tuple[int, int, int]]:
    """A table of four coefficients on two axes that is nearly the weight of body 1 on axis 1, in the data with this
    size on axis 2 alone; terms: body, table, body without body 1. Beside it 3 NOISE on each axis that have no name.
    """
    rng, n = np.random.default_rng(14), 600
    bodies, tables, unknown, noise = (rng.standard_normal((size, n)) for size in (2, 8, 2, 2))
    tables[0] = bodies[0] + 0.05 * tables[0]
    zero = np.zeros((n, 4))
    labels = tuple(Parameter(f"x{a}", axis) for axis in (0, 1) for a in range(4))
    terms = [
        Regressor(Term(Body(), (Parameter("m1"), Parameter("m2"))), (bodies.T, 0.5 * bodies.T)),
        Regressor(Term(Table(), labels), (np.c_[tables[:4].T, zero], np.c_[zero, tables[4:].T])),
    ]
    weight = np.c_[bodies.sum(axis=0), 0.5 * bodies.sum(axis=0)]
    force = 20.0 * weight + np.c_[np.zeros(n), of_table * tables[4:].sum(axis=0)] + 3.0 * unknown.T + noise.T
    criterion = machine_of_two_axes(terms, NOISE * force, 2)
    return criterion, (0, 1, criterion.part(0, (Parameter("m2"),)))


def test_table_of_a_name_gives_back_what_a_name_of_the_whole_machine_has_lost_to_it():
    """Without the weight of body 1 the table accounts for much on axis 1; with it for nothing, but on axis 2."""
    criterion, (body, table, rest) = bodies_and_tables(20.0)
    members = certain(criterion, Choice(frozenset({table, rest}), False), np.full(2, NOISE), {}).members
    assert {(criterion.terms[k].name, len(criterion.terms[k].labels)) for k in members} == {("body", 2), ("table", 4)}
    assert {label.axis for k in members - {body} for label in criterion.terms[k].labels} == {1}


class NeverNegative(ByAxis):
    name = "never negative"

    def contrasts(self, labels):
        return [{label: 1.0} for label in labels]


def test_name_that_physics_refuses_once_another_is_withdrawn_goes_with_it():
    """It could be positive on axis 2 beside a weak name alone; on axis 1 it is right, and corrections can be added."""
    rng, n = np.random.default_rng(15), 600
    (own, more), (weak, unknown), noise = rng.standard_normal((2, n)), rng.standard_normal((2, n)), 1.0
    labels = (Parameter("x", 0), Parameter("x", 1))
    zero = np.zeros(n)
    mixed = more + 2.0 * weak
    terms = [
        Regressor(Term(NeverNegative(), labels), (np.c_[own, zero], np.c_[zero, mixed])),
        Regressor(Term(Weak(), (Parameter("y"),)), (None, weak[:, None])),
        Regressor(Term(Nameless(), (Parameter("z"),)), (None, unknown[:, None])),
    ]
    force = np.c_[20.0 * own, 2.0 * more - 4.0 * weak + 8.0 * unknown] + noise * rng.standard_normal((n, 2))
    criterion = machine_of_two_axes(terms, NOISE * force, 2)
    assert criterion.refused(frozenset({0, 1})) is None
    assert criterion.refused(frozenset({0})) == (0, labels[1])
    assert _possible(criterion, frozenset({0})) == {criterion.part(0, labels[:1])}
    members = certain(criterion, Choice(frozenset({0, 1}), False), np.full(2, NOISE), {}).members
    assert members == {criterion.part(0, labels[:1]), 2}


def test_pruning_drops_what_costs_most_for_what_it_explains():
    """A table of four coefficients on axis 1, or the one of a body that it is nearly: the body stays."""
    criterion, (body, table, _) = bodies_and_tables(20.0)
    members = _pruned(criterion, frozenset({body, table}))
    assert body in members
    assert {label.axis for k in members - {body} for label in criterion.terms[k].labels} == {1}


def test_special_case_takes_an_axis_alone():
    """An offset on axis 2, springs on 3 and 4, nothing on axis 1, where a spring was not to be seen at all."""
    rng, n, axes = np.random.default_rng(16), 400, 4
    springs, noise = rng.standard_normal((2, n, axes))
    force = 20.0 * springs * (np.arange(axes) > 1) + 5.0 * (np.arange(axes) > 0) + noise
    labels = tuple(Parameter(stem, axis) for axis in range(axes) for stem in "kc")
    columns = np.zeros((axes, n, 2 * axes))
    for axis in range(axes):
        columns[axis, :, 2 * axis], columns[axis, :, 2 * axis + 1] = springs[:, axis], 1.0
    terms = [
        Regressor(Term(General(), labels[2:]), (None, *columns[1:, :, 2:])),
        Regressor(Term(Simple(), labels[1::2]), tuple(columns[..., 1::2])),
    ]
    gram = Gram(terms, NOISE * force, np.ones((n, axes)), np.full(axes, NOISE**2), np.full(axes, float(n)))
    criterion = Criterion([own.term for own in terms], gram, 2, {})
    members = _simpler_axes(criterion, frozenset({0}))
    found = {criterion.terms[k].name: {label.axis for label in criterion.terms[k].labels} for k in members}
    assert found == {"general": {2, 3}, "simple": {1}}
