"""The exact fit: what no data can tell apart stays small instead of growing without end."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Parameter, Term, Variable
from gravcomp.diagnosis.corrections import Table
from gravcomp.diagnosis.effects.coulomb_friction import DirectionalCoulombFriction
from gravcomp.diagnosis.effects.nonlinear_cable_spring import NonlinearCableSpring
from gravcomp.diagnosis.effects.stribeck_friction import StribeckFriction
from gravcomp.diagnosis.effects.viscous_friction import DirectionalViscousFriction, ViscousFriction
from gravcomp.diagnosis.fit import fit_terms
from gravcomp.logs.measurement import Measurement

N, NOISE_N, SLOPE = 600, 0.05, 40.0
VS = Parameter("vs", 0)


def motion() -> Measurement:
    t = 0.01 * np.arange(N)
    q, v = np.sin(3.0 * t)[:, None], 3.0 * np.cos(3.0 * t)[:, None]
    force = SLOPE * v + NOISE_N * np.random.default_rng(3).standard_normal((N, 1))
    return Measurement("motion", t, q, v, force, 0.0 * force, "N", ("m",), None, None, None)


def fitted(effects, corrections=()):
    data = motion()
    fit = fit_terms(data, data.force, np.arange(N), effects, list(corrections), np.array([NOISE_N]))
    return data, fit


def term(candidate, shape=None) -> Term:
    return Term(candidate, tuple(candidate.columns(motion(), shape or {})), shape or {})


@pytest.mark.parametrize("kind", [ViscousFriction, DirectionalViscousFriction])
@pytest.mark.parametrize(("beside", "shape"), [(DirectionalCoulombFriction, {}), (StribeckFriction, {VS: 0.3})])
def test_effect_that_a_table_could_be_does_not_run_away(kind, beside, shape):
    """A table with a knot at rest holds every straight line on each side of it."""
    table = Table(0, (Variable("v", 0),), (-3.0, -1.5, 0.0, 1.5, 3.0))
    data, fit = fitted([term(kind()), term(beside(), shape)], [term(table)])
    assert np.abs(list(fit.effects[0].parameters.values())).max() <= SLOPE
    assert np.sqrt(np.mean((data.force - fit.predict(data)) ** 2)) == pytest.approx(NOISE_N, rel=0.1)


def test_effect_that_the_data_tell_is_not_pulled():
    _, fit = fitted([term(ViscousFriction())])
    assert fit.effects[0].parameters["b_1"] == pytest.approx(SLOPE, abs=4 * NOISE_N / np.sqrt(N))


def test_what_stands_beside_a_fit_makes_no_sample_an_outlier():
    """A wave of nine times the noise's size has tails of its own; with it beside, every sample has weight one: least
    squares. Noise is even, +- NOISE_N, so that it has no tails.
    """
    data, rows = motion(), np.arange(N)
    wave = 9.0 * NOISE_N * np.maximum(np.sin(17.0 * data.q), 0.0) ** 8
    even = NOISE_N * np.random.default_rng(5).choice([-1.0, 1.0], (N, 1))
    force, effects = SLOPE * data.v + wave + even, [term(ViscousFriction())]
    plain = float(np.linalg.lstsq(data.v, force[:, 0], rcond=None)[0][0])
    slopes = [
        fit_terms(data, force, rows, effects, [], np.array([NOISE_N]), beside=beside).effects[0].parameters["b_1"]
        for beside in (wave, 0.0)
    ]
    assert slopes[0] == pytest.approx(plain, rel=1e-9)
    assert abs(slopes[1] - plain) > 1e-5 * plain


FALL = {Parameter("fs", 0): -0.4, Parameter("fc", 0): -0.1, VS: 0.3}


@pytest.mark.parametrize(("known", "fs", "fc"), [
    ({"stribeck_friction": {"fs_1": 1.0, "fc_1": 0.5}}, -0.4, -0.1),  # 0.6 at rest, 0.4 at speed: possible
    ({"stribeck_friction": {"fs_1": 0.5, "fc_1": 0.4}, "coulomb_friction": {"fc_1": 1.0}}, None, None),  # 1.1, 1.3
    ({"coulomb_friction": {"fc_1": 1.0}}, None, None),  # 0.6, 0.9
    ({}, None, None),
])  # fmt: skip
def test_friction_at_rest_is_never_less_than_at_speed_with_what_the_model_has(known, fs, fc):
    """A change of friction may be negative, but the sum falls with speed and stays positive."""
    data, effect = motion(), StribeckFriction()
    residual, own = effect.predict(data, FALL), [term(effect, {VS: 0.3})]
    entry = fit_terms(data, residual, np.arange(N), own, [], np.array([NOISE_N]), known=known).effects[0]
    parameters = entry.parameters
    if fs is not None:
        assert (parameters["fs_1"], parameters["fc_1"]) == pytest.approx((fs, fc), abs=1e-3)
    own, others = known.get("stribeck_friction", {}), known.get("coulomb_friction", {}).get("fc_1", 0.0)
    at_rest = others + own.get("fs_1", 0.0) + parameters["fs_1"]
    at_speed = others + own.get("fc_1", 0.0) + parameters["fc_1"]
    assert at_rest >= at_speed - 1e-6
    assert at_speed >= -1e-6


def test_effect_and_table_do_not_cancel_each_other_at_the_few_places_of_a_log():
    """At five places, to a part in 1e5, a table is any curve. What both could carry the curve of the cable carries, and
    between the places it is right to within the noise, where large ones that cancel are wrong by far more.
    """
    rng, places = np.random.default_rng(7), np.linspace(-1.0, 1.0, 5)
    spring, truth = NonlinearCableSpring(), {Parameter(f"k{k}", 0): value for k, value in ((1, 2.0), (2, 1.0))}

    def log(q):
        t, nothing = 1.0 * np.arange(N), np.zeros((N, 1))
        return Measurement("holds", t, q[:, None], None, nothing, nothing, "N", ("m",), None, None, None)

    holds, between = log(rng.choice(places, N) + 1e-5 * rng.standard_normal(N)), log(rng.uniform(-1.0, 1.0, N))
    force = spring.predict(holds, truth) + NOISE_N * rng.standard_normal((N, 1))
    table = Table(0, (Variable("q", 0),), tuple(places))
    own = Term(spring, tuple(truth), spring.shapes(holds)[0])
    beside = Term(table, tuple(table.columns(holds)))
    fit = fit_terms(holds, force, np.arange(N), [own], [beside], np.array([NOISE_N]))
    error = fit.predict(between) - spring.predict(between, truth)
    assert np.abs(error).max() < 4 * NOISE_N
    assert np.abs(fit.corrections[0].force(between)).max() < 4 * NOISE_N
