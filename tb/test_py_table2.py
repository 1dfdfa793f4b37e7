"""The paper's Table 2: holds on the field, training on few points, the core after the loop, and the command."""

import numpy as np
import pytest

from gravcomp.diagnosis.candidate import Parameter, Term
from gravcomp.diagnosis.effects.coulomb_friction import CoulombFriction
from gravcomp.diagnosis.fit import Entry, Fit
from gravcomp.network.activation import gamma
from gravcomp.network.weights import load_network
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.workspace import sample_workspace
from gravcomp_lab.__main__ import main
from gravcomp_lab.paper.field import APPROACHES, hold_field
from gravcomp_lab.paper.field_core import FieldCore, build_core
from gravcomp_lab.paper.fine_tuning import WAYS, fine_tune, tune_by_validation
from gravcomp_lab.paper.table2 import (
    ANALYTIC,
    FIELD,
    HOLDS,
    MOTION,
    PAPER,
    TORSIONS_DEG,
    TRUTH,
    SampleCounts,
    core_row,
    findings,
    found_row,
    markdown,
    table2,
)
from machines import MACHINE, P

NETWORK = load_network("weights/spheiro")


@pytest.fixture(scope="module")
def table():
    return table2(MACHINE, NETWORK, 3, SampleCounts(training=60, test=30, motion=50, retraining=120))


@pytest.fixture(scope="module")
def outward():
    return hold_field(MACHINE, sample_workspace(40, P, 1), "outward", 2)


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


def average(table, approach, row):
    return np.mean([error.average_percent for error in table.errors[approach][row].values()])


def test_table_has_the_papers_rows_and_those_it_does_not_have(table):
    expected = {*PAPER, TRUTH, *(row(source) for row in (found_row, core_row) for source in (HOLDS, MOTION))}
    for approach in APPROACHES:
        assert set(table.errors[approach]) == expected
        assert all(set(by_torsion) == set(TORSIONS_DEG) for by_torsion in table.errors[approach].values())


def test_network_learns_friction_on_the_field_only_if_the_pose_tells_its_direction(table):
    gain = {a: average(table, a, FIELD) / average(table, a, ANALYTIC) for a in APPROACHES}
    print(f"average error of the network trained on the field, over that of the analytic model: {gain}")
    assert gain["outward"] < 0.75
    assert gain["random"] > 0.9


def test_effects_found_in_holds_lower_the_error_of_model_and_core(table):
    for row in (found_row(HOLDS), core_row(HOLDS)):
        assert average(table, "random", row) < 0.8 * average(table, "random", ANALYTIC)


def test_table_prints_the_papers_figures_and_what_was_found(table):
    lines = markdown(table).splitlines()
    assert lines[2].startswith(f"| {FIELD} | 0° | 7.0 | 2.8 | ")
    assert len({line.count("|") for line in lines}) == 1
    assert len(lines) == 2 + len(TORSIONS_DEG) * 8
    assert all(way in findings(table) for way in WAYS)


def test_holds_are_the_same_for_the_same_seed_and_differ_for_another(outward):
    again = hold_field(MACHINE, sample_workspace(40, P, 1), "outward", 2)
    other = hold_field(MACHINE, sample_workspace(40, P, 1), "outward", 3)
    np.testing.assert_array_equal(again.force, outward.force)
    assert np.abs(other.force - outward.force).max() > 0.05


def test_outward_approach_moves_away_from_home_and_a_random_one_does_not(outward):
    random = hold_field(MACHINE, sample_workspace(40, P, 1), "random", 2)
    away = [np.mean(np.sum(data.v * data.q, axis=1) > 0) for data in (outward, random)]
    assert away[0] > 0.95
    assert 0.2 < away[1] < 0.8


def test_training_of_the_output_layer_is_least_squares_with_a_ridge(outward):
    tuned = fine_tune(NETWORK, outward.q, outward.force, 0.3, "output layer")
    x = (outward.q - NETWORK.q_offset) * NETWORK.q_scale
    act = np.c_[gamma(x @ NETWORK.hidden_weights.T + NETWORK.hidden_bias), np.ones(len(x))]
    error = (outward.force - NETWORK.forces(outward.q)) / NETWORK.f_scale
    step = np.linalg.solve(act.T @ act + 0.3 * np.eye(act.shape[1]), act.T @ error).T
    np.testing.assert_array_equal(tuned.hidden_weights, NETWORK.hidden_weights)
    np.testing.assert_allclose(tuned.output_weights - NETWORK.output_weights, step[:, :-1], atol=1e-10)
    np.testing.assert_allclose(tuned.output_bias - NETWORK.output_bias, step[:, -1], atol=1e-10)


def test_all_weights_fit_the_points_closer_than_the_output_layer(outward):
    layer, everything = (fine_tune(NETWORK, outward.q, outward.force, 0.01, way) for way in WAYS)
    assert rms(everything.forces(outward.q) - outward.force) < 0.9 * rms(layer.forces(outward.q) - outward.force)


@pytest.mark.parametrize("way", WAYS)
def test_training_on_noise_stays_near_the_network_it_started_from(way):
    q = inverse_kinematics(sample_workspace(100, P, 8), P)
    noise = np.random.default_rng(4).standard_normal(q.shape)
    tuned = tune_by_validation(NETWORK, q, NETWORK.forces(q) + noise, way, 5)
    # Without a ridge the 21 weights per output follow sqrt(21/100) = 0.46 N of the noise, all weights more.
    assert rms(tuned.network.forces(q) - NETWORK.forces(q)) < 0.25


def test_core_holds_the_statics_without_effects_and_adds_friction_with_them(outward):
    friction = Entry(Term(CoulombFriction(), (Parameter("fc", 0),)), {Parameter("fc", 0): 1.5}, {}, 0.0)
    plain, rubbing = (build_core(Fit(e), outward, NETWORK, MACHINE, 150, 7) for e in ((), (friction,)))
    assert isinstance(plain, FieldCore)
    assert rms(plain.forces(outward) - outward.nominal) < 0.3
    added = rubbing.forces(outward) - plain.forces(outward)
    is_moving = np.abs(outward.v[:, 0]) > 1.1 * rubbing.constants.v_full[0]  # the slowest have it in part
    assert is_moving.mean() > 0.8
    # 2 mN: the table's rounding and that of the two ends of its interpolation.
    np.testing.assert_allclose(added[is_moving], 1.5 * np.sign(outward.v[is_moving]) * [1, 0, 0], atol=2e-3)


def test_command_prints_the_table_and_writes_it(table, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("gravcomp_lab.commands.table2.table2", lambda *_: table)
    out = tmp_path / "table2.md"
    assert main(["table2", "--seed", "3", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert markdown(table) in printed
    assert "seed 3" in printed
    assert markdown(table) in out.read_text()
    assert findings(table) in out.read_text()


@pytest.mark.parametrize(
    ("arguments", "named"), [(["--seed", "-1"], "--seed -1"), (["--weights", "nowhere"], "nowhere")]
)
def test_bad_arguments_end_in_one_line_and_status_2(arguments, named, tmp_path, capsys):
    assert main(["table2", "--out", str(tmp_path / "table2.md"), *arguments]) == 2
    error = capsys.readouterr().err
    assert named in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
