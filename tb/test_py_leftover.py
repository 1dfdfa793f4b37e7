"""What is left after a fit: structure is found with its axis and variable, noise and a handful of samples give none."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Parameter, Term, Variable
from gravcomp.diagnosis.corrections import Line, Table
from gravcomp.diagnosis.effects.coulomb_friction import CoulombFriction
from gravcomp.diagnosis.effects.thermal_drift import ThermalDrift
from gravcomp.diagnosis.fit import Entry, Fit
from gravcomp.diagnosis.leftover import drivers, find, unavailable
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
    assert unavailable(few, np.arange(399), block_labels(few, 0)) == "399 samples to train on, 400 are needed"


def test_few_blocks_are_not_asked():
    blocks = np.arange(600) // 200
    assert find(HOLDS, np.ones(HOLDS.shape), np.arange(600), blocks, NOISE, 0) == []
    assert "fewer than 4" in unavailable(HOLDS, np.arange(600), blocks)
    assert unavailable(HOLDS, np.arange(600), block_labels(HOLDS, 0)) == ""


def test_a_block_of_which_no_sample_is_used_is_none():
    """Of 6000 samples 2500 at equal distances are used: not this one."""
    data = motion(6000)
    blocks = np.arange(6000) // 2000
    blocks[3001] = 3
    assert find(data, np.ones(data.shape), np.arange(6000), blocks, NOISE, 0) == []
    assert "fewer than 4" in unavailable(data, np.arange(6000), blocks)


def entry_of(candidate, parameters):
    named = {Parameter.parse(name): value for name, value in parameters.items()}
    return Entry(Term(candidate, tuple(named)), named, {}, 0.0)


def drivers_of(effects, corrections, left, after):
    """Of a fit that is right: what was before is its forces and what is left, (n, k); the first 150 rows held out."""
    fit = Fit(tuple(effects), tuple(corrections))
    use = np.broadcast_to((np.arange(600) < 150)[:, None], HOLDS.shape)
    return drivers(HOLDS, use, fit.predict(HOLDS) + after, after, fit, left)


def test_drivers_are_unexplained_structure_first_then_what_effects_follow():
    friction = entry_of(CoulombFriction(), {"fc_2": 0.5})
    table = Table(2, (Variable("q", 0),), (-0.08, 0.0, 0.08))
    bowl = entry_of(table, {"value_0": 1.0, "value_1": 0.0, "value_2": 1.0})
    after = np.zeros(HOLDS.shape)
    after[:, 0] = 0.4  # the axis that neither has a part in
    found = drivers_of([friction], [bowl], [{"axis": 1, "variable": "t", "share": 0.2}], after)
    assert [(item["axis"], item["variable"]) for item in found] == [(3, "q1"), (1, "t"), (2, "dir2")]
    energy = np.array([np.sum(bowl.force(HOLDS)[:150] ** 2), 0.2 * 150 * 0.16, 150 * 0.25])
    whole = energy[0] + 150 * 0.16 + energy[2]
    assert [item["share"] for item in found] == pytest.approx(energy / whole)


def test_drivers_of_two_corrections_that_take_from_one_another_are_what_each_brings():
    """2 sign v less 1 sign v: what is there is explained to twice and to minus once its size."""
    twice, back = (
        entry_of(CoulombFriction(), {"fc_2": 2.0}),
        entry_of(Line(1, (Variable("dir", 1),)), {"value_0": -1.0}),
    )
    found = drivers_of([twice], [back], [], np.zeros(HOLDS.shape))
    assert {item["of"]: item["share"] for item in found} == pytest.approx({"": -1.0, "coulomb_friction": 2.0})


def test_drivers_of_drift_is_the_temperature_where_it_is_measured():
    drift = entry_of(ThermalDrift(), {"gain_1": 1e-3, "t0_1": 30.0})
    assert [(item["axis"], item["variable"]) for item in drivers_of([drift], [], [], 0.1 * np.ones(HOLDS.shape))] == [
        (1, "temp")
    ]


def test_drivers_too_small_to_matter_are_not_told():
    friction, after = entry_of(CoulombFriction(), {"fc_2": 0.05}), np.zeros(HOLDS.shape)
    after[:, 0] = 1.0  # of which it explains nothing
    assert drivers_of([friction], [], [], after) == []
