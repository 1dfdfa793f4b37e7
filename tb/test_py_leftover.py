"""What is left after a fit: structure is found with its axis and variable, noise and a handful of samples give none."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Parameter, Term, Variable
from gravcomp.diagnosis.corrections import Table
from gravcomp.diagnosis.effects.coulomb_friction import CoulombFriction
from gravcomp.diagnosis.effects.thermal_drift import ThermalDrift
from gravcomp.diagnosis.fit import Entry, Fit
from gravcomp.diagnosis.leftover import drivers, find
from gravcomp.diagnosis.samples.split import block_labels
from measured_samples import holds, motion

HOLDS, MOTION = holds(600, 1), motion(1200)
NOISE = np.array([0.1, 0.2, 0.3])


def left_in(data, structure, seed=0):
    """Drivers found in noise with structure {axis: values in units of its noise}."""
    after = NOISE * np.random.default_rng(seed).standard_normal(data.shape)
    for axis, values in structure.items():
        after[:, axis - 1] += NOISE[axis - 1] * values
    return find(data, after, np.arange(len(after)), block_labels(data, 0), NOISE, 0)


def bump(x, width):
    return 4.0 * np.exp(-((x / width) ** 2))


@pytest.mark.parametrize(
    ("data", "axis", "values", "variable"),
    [
        (HOLDS, 2, bump(HOLDS.q[:, 0], 0.02), "q1"),
        (HOLDS, 3, 1.2 * np.sign(HOLDS.v[:, 2]) * (HOLDS.q[:, 2] > 0), "dir3"),
        (HOLDS, 1, 1.0 * (HOLDS.t_s > 600.0), "t"),
        (MOTION, 2, bump(MOTION.q[:, 1], 0.02), "q2"),
    ],
)
def test_structure_is_found_on_its_axis_with_its_variable(data, axis, values, variable):
    found = left_in(data, {axis: values})
    assert [item["axis"] for item in found] == [axis]
    known = {variable, variable.replace("t", "temp")} if variable == "t" else {variable, variable.replace("dir", "v")}
    assert found[0]["variable"] in known  # temperature rises with time, the direction is the sign of v
    share = values.var() / (values.var() + 1.0)
    assert 0.3 * share < found[0]["share"] < 1.1 * share


def test_structure_on_two_axes_is_found_on_both():
    found = left_in(HOLDS, {1: bump(HOLDS.q[:, 0], 0.02), 3: bump(HOLDS.q[:, 1], 0.03)})
    assert [(item["axis"], item["variable"]) for item in found] == [(1, "q1"), (3, "q2")]


@pytest.mark.parametrize("data", [HOLDS, MOTION], ids=["holds", "motion"])
def test_noise_has_no_structure(data):
    assert [left_in(data, {}, seed) for seed in range(3)] == [[], [], []]


def test_few_samples_are_not_asked():
    few = holds(399, 1)
    assert left_in(few, {2: 5 * np.sign(few.q[:, 0])}) == []


def entry_of(candidate, parameters):
    named = {Parameter.parse(name): value for name, value in parameters.items()}
    return Entry(Term(candidate, tuple(named)), named, {}, 0.0)


def drivers_of(effects, corrections, left, before):
    fit = Fit(tuple(effects), tuple(corrections))
    shares = {entry.name: 0.4 for entry in fit.entries}
    return drivers(HOLDS, np.arange(600) < 150, before, 0.5 * before, fit, shares, left)


def test_drivers_are_unexplained_structure_first_then_what_effects_follow():
    friction = entry_of(CoulombFriction(), {"fc_2": 0.5})
    table = Table(2, (Variable("q", 0),), (-0.08, 0.0, 0.08))
    bowl = entry_of(table, {"value_0": 1.0, "value_1": 0.0, "value_2": 1.0})
    before = np.ones(HOLDS.shape)
    found = drivers_of([friction], [bowl], [{"axis": 1, "variable": "t", "share": 0.2}], before)
    assert [(item["axis"], item["variable"]) for item in found] == [(3, "q1"), (1, "t"), (2, "dir2")]
    # shares of the square sum before: 0.4 as given, 0.2 of the quarter that is left, 0.5^2 of one axis in three
    assert [item["share"] for item in found] == pytest.approx([0.4, 0.05, 0.25 / 3])


def test_drivers_of_drift_is_the_temperature_where_it_is_measured():
    drift = entry_of(ThermalDrift(), {"gain_1": 1e-3, "t0_1": 30.0})
    assert [(item["axis"], item["variable"]) for item in drivers_of([drift], [], [], np.ones(HOLDS.shape))] == [
        (1, "temp")
    ]


def test_drivers_too_small_to_matter_are_not_told():
    friction = entry_of(CoulombFriction(), {"fc_2": 0.05})
    assert drivers_of([friction], [], [], np.ones(HOLDS.shape)) == []
