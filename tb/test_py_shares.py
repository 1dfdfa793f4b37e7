"""Shares of entries that overlap: what each alone explains, and what several do, add up to what is explained."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Parameter, Term, Variable
from gravcomp.diagnosis.corrections import Line, Table
from gravcomp.diagnosis.effects.coulomb_friction import CoulombFriction
from gravcomp.diagnosis.effects.viscous_friction import ViscousFriction
from gravcomp.diagnosis.fit import Entry, Fit
from gravcomp.diagnosis.shares import along, shares
from measured_samples import holds

DATA = holds(800, 1)
TRAIN = np.arange(800)[:, None] >= 200 * np.ones(3)
NOISE = 0.1 * np.random.default_rng(2).standard_normal(DATA.shape)


def entry(candidate, parameters) -> Entry:
    named = {Parameter.parse(name): value for name, value in parameters.items()}
    return Entry(Term(candidate, tuple(named)), named, {}, 0.0)


def shares_of(effects, corrections=(), after=NOISE):
    fit = Fit(tuple(effects), tuple(corrections))
    return shares(DATA, fit, TRAIN.astype(float), ~TRAIN, fit.predict(DATA) + after, after)


def beside(y, x):
    """Square sum on the held-out samples of y less the multiple of x that is nearest on the others."""
    used, held = TRAIN[:, 0], ~TRAIN[:, 0]
    return np.sum((y - x * (x[used] @ y[used]) / (x[used] @ x[used]))[held] ** 2)


def test_shares_of_friction_that_overlaps_are_those_of_the_formula():
    """sign v and v of one axis go together: each alone explains what the other cannot."""
    s, v = DATA.direction[:, 0], DATA.v[:, 0]
    found = shares_of(
        [entry(CoulombFriction(), {"fc_1": 1.0}), entry(ViscousFriction(), {"b_1": 200.0})], after=0 * NOISE
    )
    total = np.sum((s + 200.0 * v)[:200] ** 2)
    assert found.unique["coulomb_friction"] == pytest.approx(beside(s, v) / total)
    assert found.unique["viscous_friction"] == pytest.approx(beside(200.0 * v, s) / total)
    assert found.joint > 0.4
    assert sum(found.unique.values()) + found.joint + found.left == pytest.approx(1.0)


def test_entries_that_have_nothing_in_common_have_no_joint_share():
    found = shares_of(
        [entry(CoulombFriction(), {"fc_1": 1.0})], [entry(Line(1, (Variable("q", 0),)), {"value_0": 20.0})]
    )
    assert found.joint == pytest.approx(0.0, abs=0.02)
    assert found.of_corrections == found.unique["axis 2: q1"] > 0.3


def test_correction_that_an_effect_can_take_over_explains_nothing_beside_it():
    same = entry(Line(0, (Variable("dir", 0),)), {"value_0": 0.5})
    found = shares_of([entry(CoulombFriction(), {"fc_1": 1.0})], [same])
    assert found.of_corrections == pytest.approx(0.0, abs=1e-6)
    assert found.joint > 0.5


def test_corrections_of_one_name_have_one_share():
    knots = (-0.08, 0.0, 0.08)
    bowl = entry(Table(0, (Variable("q", 0),), knots), {"value_0": 1.0, "value_1": 0.0, "value_2": 1.0})
    line = entry(Line(0, (Variable("q", 0),)), {"value_0": 20.0})
    found = shares_of([], [bowl, line])
    assert list(found.unique) == ["axis 1: q1"]
    assert found.unique["axis 1: q1"] == pytest.approx(1.0 - found.left, abs=1e-9)


def test_parts_along_the_residual_add_up_to_it():
    entries = [entry(CoulombFriction(), {"fc_1": 3.0}), entry(ViscousFriction(), {"b_1": -400.0})]
    before = Fit(tuple(entries)).predict(DATA) + NOISE
    use = ~TRAIN
    parts = sum(along(DATA, own, use, before) for own in entries) + np.sum(np.where(use, NOISE * before, 0.0), axis=0)
    np.testing.assert_allclose(parts, np.sum(np.where(use, before**2, 0.0), axis=0))
