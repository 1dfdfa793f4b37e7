"""The diagnosis names what was put into the data, nothing where nothing is, and no physics it cannot show."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.model import Model, load_model, model_toml
from gravcomp.diagnosis.report.report import report
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.statics import holding_forces_at
from gravcomp.robot.spheiro.workspace import sample_workspace
from machines import MACHINE, SHIPPED, P

NOISE_N = 0.3
N = 400


def holds(force=None, seed=7):
    """CSV of static holds with an extra force(q, v), N."""
    rng = np.random.default_rng(seed)
    q = inverse_kinematics(sample_workspace(N, P, seed), P)
    v = rng.choice([-1.0, 1.0], q.shape) * rng.uniform(0.001, 0.01, q.shape)
    f = holding_forces_at(q, P) + NOISE_N * rng.standard_normal(q.shape)
    f = f if force is None else f + force(q, v)
    head = "t_s," + ",".join(f"{c}{i}_{u}" for c, u in (("q", "m"), ("v", "mps"), ("f", "n")) for i in (1, 2, 3))
    rows = np.column_stack([2.0 * np.arange(N), q, v, f])
    return head + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows) + "\n"


def in_hinges(q, moment):
    """Motor forces of moments (n, 6), of the Jacobian, in the hinges of the universal joints."""
    jacobian = MACHINE.robot.universal_jacobian(q)
    return np.einsum("nij,ni->nj", jacobian, moment(jacobian))


def run(tmp_path, text, *options):
    """Exit status and report of the command line."""
    data, out = tmp_path / "log.csv", tmp_path / "out"
    data.write_text(text)
    robot = [] if "--robot" in options else ["--robot", str(SHIPPED)]
    status = main(["diagnose", str(data), "--out", str(out), *robot, *options])
    return status, json.loads((out / "report.json").read_text()) if status == 0 else None


@pytest.mark.parametrize(
    ("name", "force"),
    [
        ("coulomb_friction", lambda q, v: 0.8 * np.sign(v)),
        ("viscous_friction", lambda q, v: 100.0 * v),
        ("thrust_constant", lambda q, v: 0.02 * holding_forces_at(q, P)),
        ("encoder_offset", lambda q, v: holding_forces_at(q + 0.002, P) - holding_forces_at(q, P)),
        ("cogging", lambda q, v: 0.8 * np.sin(2 * np.pi * q / 0.024 + 1.0)),
        ("universal_joint_friction", lambda q, v: in_hinges(q, lambda j: 0.3 * np.sign(np.einsum("nij,nj->ni", j, v)))),
        (
            "platform_hose",
            lambda q, v: in_hinges(q, lambda j: MACHINE.robot.universal_angles(q) * np.repeat([0, 2], 3)),
        ),
    ],
)
def test_diagnosis_names_the_effect_and_leaves_noise(tmp_path, name, force):
    status, found = run(tmp_path, holds(force))
    assert status == 0
    assert [effect["name"] for effect in found["effects"]] == [name]
    assert found["verdict"] == "explained"
    assert found["after"]["rms_n"] < 1.1 * NOISE_N < found["before"]["rms_n"]


def test_diagnosis_names_nothing_in_noise(tmp_path):
    _, found = run(tmp_path, holds())
    assert found["verdict"] == "nothing_missing"
    assert found["effects"] == []
    assert found["before"] == found["after"]


STOPS = [(60.0, 0.03), (30.0, 0.0), (60.0, 0.05), (120.0, 0.0), (1000.0, 0.05)]


@pytest.mark.parametrize(("stiffness", "corner"), STOPS)
def test_diagnosis_gives_an_unlisted_effect_its_driver_and_no_name(tmp_path, stiffness, corner):
    """A stop, N/m and m; the soft ones are to within the noise a polynomial of fourth order, as a cable is."""

    def stop(q, v):
        return -np.stack([stiffness * np.maximum(q[:, 0] - corner, 0.0), 0 * q[:, 1], 0 * q[:, 2]], axis=1)

    _, found = run(tmp_path, holds(stop))
    assert found["effects"] == []
    assert found["verdict"] == "unexplained"
    assert (found["drivers"][0]["axis"], found["drivers"][0]["variable"]) == (1, "q1")


def test_zero_of_an_encoder_is_no_payload_beside_it(tmp_path):
    """8 mm is so far that the force of the offset is curved; a payload would be what its first order misses."""
    offset = np.array([0.008, 0.007, -0.006])
    _, found = run(tmp_path, holds(lambda q, v: holding_forces_at(q + offset, P) - holding_forces_at(q, P)))
    assert [effect["name"] for effect in found["effects"]] == ["encoder_offset"]
    assert found["verdict"] == "explained"


def test_saturation_of_the_effort_is_no_friction(tmp_path):
    """f |f| is friction with the square of the load where the motor drives, and its opposite where the load does."""

    def saturation(q, v):
        f = holding_forces_at(q, P)
        return -2e-4 * f * np.abs(f) * [1.0, 0.0, 0.0]

    _, found = run(tmp_path, holds(saturation))
    assert found["effects"] == []
    assert found["drivers"][0]["variable"] == "f1"


def test_intervals_cover_the_true_coefficient(tmp_path):
    _, found = run(tmp_path, holds(lambda q, v: 0.8 * np.sign(v)))
    intervals = found["effects"][0]["ci95"]
    assert sum(low < 0.8 < high for low, high in intervals.values()) >= len(intervals) - 1


def test_model_reloaded_leaves_nothing_missing(tmp_path):
    text = holds(lambda q, v: 0.8 * np.sign(v) + 0.02 * holding_forces_at(q, P))
    run(tmp_path, text)
    _, found = run(tmp_path, text, "--robot", str(tmp_path / "out" / "model.toml"))
    assert found["verdict"] == "nothing_missing"


def test_model_toml_survives_a_round_trip(tmp_path):
    for machine in (None, MACHINE):
        model = Model(machine, [("coulomb_friction", {"fc_1": 1.25}), ("payload", {"moment_x": 0.1})])
        (tmp_path / "m.toml").write_text(model_toml(model))
        again = load_model(tmp_path / "m.toml")
        assert again.effects == model.effects
        assert model_toml(again) == model_toml(model)
        assert (again.machine is None) == (machine is None)


def test_report_is_the_same_for_the_same_seed(tmp_path):
    text = holds(lambda q, v: 0.8 * np.sign(v))
    assert run(tmp_path, text)[1] == run(tmp_path, text)[1]


def test_held_out_samples_reach_no_fit(tmp_path):
    (tmp_path / "log.csv").write_text(holds(lambda q, v: 0.8 * np.sign(v)))
    data = read_measurement(tmp_path / "log.csv", MACHINE)
    first = diagnose(data, Model())
    spoilt = np.where(first.is_test[:, None], data.force + 50.0, data.force)
    second = diagnose(replace(data, force=spoilt), Model())
    assert report(second)["effects"][0]["params"] == report(first)["effects"][0]["params"]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda s: s.replace("t_s,", "time,", 1), "t_s"),
        (lambda s: s.replace("q2_m", "q2_ft", 1), "q2"),
        (lambda s: "\n".join([*s.splitlines()[:5], "off" + s.splitlines()[5][1:], *s.splitlines()[6:]]), "row 6"),
        (lambda s: "\n".join([*s.splitlines()[:5], s.splitlines()[5] + ",1", *s.splitlines()[6:]]), "row 6"),
        (lambda s: "\n".join(s.splitlines()[:10]), "at least"),
        (lambda s: s.replace("\n2,", "\n2,9", 1), "row"),
        (lambda s: "", "row 1"),
    ],
)
def test_bad_input_ends_in_one_line_and_writes_nothing(tmp_path, capsys, change, told):
    assert run(tmp_path, change(holds()))[0] == 2
    message = capsys.readouterr().err.strip()
    assert "\n" not in message
    assert told in message
    assert "log.csv" in message
    assert not (tmp_path / "out").exists()
