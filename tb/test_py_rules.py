"""Names beside what has none: a small effect keeps its name beside noise, and loses it beside more of the unknown."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Candidate, Parameter, Regressor, Term
from gravcomp.diagnosis.criterion import Criterion
from gravcomp.diagnosis.gram import Gram
from gravcomp.diagnosis.rules import Choice, certain

N, NOISE = 400, 0.1


class Named(Candidate):
    name, price = "named", 8.0


class Nameless(Candidate):
    name, price = "nameless", 20.0


def certain_names(effect: float, unknown: float) -> set[str]:
    """What stays named of one effect and one correction whose forces have these sizes, in units of the noise."""
    rng = np.random.default_rng(4)
    columns = rng.standard_normal((2, N, 1))
    force = NOISE * (effect * columns[0] + unknown * columns[1] + rng.standard_normal((N, 1)))
    terms = [
        Regressor(Term(kind(), (Parameter("x"),)), (own,)) for kind, own in zip((Named, Nameless), columns, strict=True)
    ]
    gram = Gram(terms, force, np.ones((N, 1)), np.array([NOISE**2]), np.array([float(N)]))
    criterion = Criterion([own.term for own in terms], gram, 1, {})
    choice = certain(criterion, Choice(frozenset({0, 1}), True), np.array([NOISE]))
    return {criterion.terms[k].name for k in choice.members}


@pytest.mark.parametrize(("effect", "unknown", "stays"), [
    (1.0, 0.3, True),  # what the name leaves is no more than noise
    (4.0, 2.0, True),  # 16 against 4: four times
    (2.0, 2.0, False),  # as much unknown as named
    (0.5, 2.0, False),
])  # fmt: skip
def test_name_needs_three_times_what_no_name_accounts_for(effect, unknown, stays):
    found = certain_names(effect, unknown)
    assert ("named" in found) == stays
    assert "nameless" in found
