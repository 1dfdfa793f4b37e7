"""A log with the user's own predictions, of a robot that the machine folder knows: effects of physics can be told."""

import json

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.robot.machine import load_machine
from mechanisms import WEIGHTS

ARM, UR5 = load_machine(WEIGHTS / "arm2"), load_machine(WEIGHTS / "ur5")
NOISE_NM = 0.02


def log_text(machine, effect, n=240, seed=1, gain=1.0):
    """Holds all over the workspace, approached from random sides, with fm columns that are gain times the statics."""
    rng, k = np.random.default_rng(seed), machine.n_axes
    q = machine.robot.workspace(n, seed)
    v = rng.choice([-1.0, 1.0], (n, k)) * rng.uniform(0.005, 0.02, (n, k))
    model = gain * machine.robot.forces(q)
    force = model + effect(q, v) + NOISE_NM * rng.standard_normal(q.shape)
    axes = range(1, k + 1)
    names = ["t_s", *(f"q{i}_rad" for i in axes), *(f"v{i}_radps" for i in axes)]
    names += [*(f"f{i}_nm" for i in axes), *(f"fm{i}_nm" for i in axes)]
    rows = np.column_stack([3.0 * np.arange(n), q, v, force, model])
    return "\n".join([",".join(names), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n"


def diagnosed(folder, machine, effect):
    (folder / "log.csv").write_text(log_text(machine, effect))
    arguments = ["diagnose", str(folder / "log.csv"), "--robot", str(WEIGHTS / machine.name)]
    assert main([*arguments, "--out", str(folder / "out")]) == 0
    return json.loads((folder / "out" / "report.json").read_text())["effects"]


def test_moment_of_a_body_is_found_in_a_log_with_predictions_and_says_which_body(tmp_path):
    body = UR5.robot.body_names.index("forearm_link")

    def effect(q, v):
        return UR5.robot.moment_regressors(q)[:, :, body] @ [0.25, 0.1, -0.05]

    (found,) = diagnosed(tmp_path, UR5, effect)
    assert found["name"] == "body_moment"
    assert {name.rsplit("_", 1)[0] for name in found["params"]} == {"moment_forearm_link"}


def test_backlash_of_six_axes_is_found_with_predictions_and_the_robot(tmp_path):
    gap = np.array([0.0, 0.03, 0.05, 0.0, 0.0, 0.0])

    def effect(q, v):
        return UR5.robot.forces(q - gap / 2 * np.sign(v)) - UR5.robot.forces(q)

    (found,) = diagnosed(tmp_path, UR5, effect)
    assert found["name"] == "backlash"
    assert found["params"]["gap_2"] == pytest.approx(0.03, rel=0.2)
    assert found["params"]["gap_3"] == pytest.approx(0.05, rel=0.2)


def read(tmp_path, machine, gain):
    (tmp_path / "log.csv").write_text(log_text(ARM, lambda q, v: 0.0 * q, gain=gain))
    return read_measurement(tmp_path / "log.csv", machine)


def test_robot_that_holds_something_else_is_left_aside_and_said(tmp_path):
    same, other = read(tmp_path, ARM, 1.1), read(tmp_path, ARM, 3.0)
    assert same.robot is ARM.robot
    assert same.is_predicted
    assert other.robot is None
    assert any("left aside: its efforts differ from them by 67 % RMS" in note for note in other.notes)
    six_axes = read(tmp_path, UR5, 1.0)
    assert six_axes.robot is None
    assert any("left aside: it has q1_rad" in note for note in six_axes.notes)
