"""A robot that is a CSV of poses and efforts: its rows are what it knows."""

import json

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.robot.machine import load_machine
from gravcomp.robot.protocol import PoseError
from gravcomp.training.training import Effort, training_and_test_set
from mechanisms import mechanism_toml

HEAD = "# of my own model\nq1_m, q2_rad, f1_n, f2_nm\n"
ROWS = np.array([[0.1, -0.5, 3.0, 1.0], [0.2, 0.5, -4.0, 2.0], [0.3, 0.25, 5.0, -0.5]])
AXES = {"": "counts_per_m = 1000000", "turn": ""}


def write(folder, text=None, axes=AXES):
    rows = "".join(",".join(map(repr, map(float, row))) + "\n" for row in ROWS)
    (folder / "own.csv").write_text(HEAD + rows if text is None else text)
    (folder / "robot.toml").write_text(mechanism_toml(axes, "own.csv", kind="table").replace('joint = ""\n', ""))
    return folder


def test_table_knows_its_rows_and_refuses_what_lies_between(tmp_path):
    machine = load_machine(write(tmp_path))
    robot = machine.robot
    assert machine.position_units == ("m", "rad")
    np.testing.assert_array_equal(robot.forces(ROWS[::-1, :2]), ROWS[::-1, 2:])
    with pytest.raises(
        PoseError, match=r"pose 2: \(0.15, 0\) is no row of own.csv, and between its rows nothing"
    ) as no:
        robot.forces(np.array([[0.1, -0.5], [0.15, 0.0]]))
    assert no.value.index == 1
    assert sorted(robot.workspace(3, 1)[:, 0]) == [0.1, 0.2, 0.3]
    assert (machine.axes[0].low, machine.axes[1].high) == (0.1, 0.5)
    assert "own.csv sha256" in machine.trained_on()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("q1_m,f1_n\n", "no rows below the header"),
        ("q1_m,f1_n\n0.1,x\n", "row 1, column f1_n: 'x' is not a finite number"),
        ("q1_m,q2_rad,f1_n\n0.1,0.2,3\n", "column f2_nm is missing"),
        ("q1_m,q3_rad,f1_n\n0.1,0.2,3\n", "give columns q1_m or q1_rad, q2_... for the axes 1 to n"),
        ("q1_m,q1_rad,f1_n\n0.1,0.2,3\n", "give columns q1_m or q1_rad, q2_... for the axes 1 to n"),
        ("q1_m,q2_rad,f1_n,f2_nm\n0.1,0.2,3,4\n0.1,0.3,3,4\n", "axis 1 stands still in all rows"),
        (
            "q1_rad,q2_rad,f1_nm,f2_nm\n0.1,0.2,3,4\n0.2,0.3,3,4\n",
            "axis 1: counts_per_turn is missing; the",
        ),
        ("q1_m,f1_n\n0.1,3\n0.2,4\n", "2 tables [[axis]], but the robot has 1 axes"),
    ],
)
def test_bad_table_is_refused_in_one_line(tmp_path, text, words, capsys):
    assert main(["train", "--robot", str(write(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert words in complaint
    assert not (tmp_path / "out").exists()


def test_network_is_trained_on_a_table_alone_and_tested_on_rows_that_it_has_not_seen(tmp_path, capsys, monkeypatch):
    """Efforts of a planar arm by formula, over a table of poses; the folder that is written is whole."""
    q = np.random.default_rng(1).uniform(-1, 1, (900, 2))
    f = np.stack([9 * np.cos(q[:, 0]) + 3 * np.cos(q.sum(axis=1)), 3 * np.cos(q.sum(axis=1))], axis=1)
    lines = [",".join(map(repr, map(float, row))) for row in np.c_[q, f]]
    samples = tmp_path / "samples.csv"
    samples.write_text("q1_rad,q2_rad,f1_nm,f2_nm\n" + "\n".join(lines) + "\n")
    (tmp_path / "robot.toml").write_text(mechanism_toml({"one": "", "two": ""}, "absent.urdf"))
    out = tmp_path / "out"
    how = ["--robot", str(tmp_path), "--hidden", "12", "--starts", "1", "--data", str(samples), "--out", str(out)]
    short = Effort(draws=3, tied_hops=2, hops=2, search_poses=200)
    monkeypatch.setattr("gravcomp.training.training.Effort", lambda: short)
    assert main(["train", *how]) == 0
    machine, known = load_machine(out), json.loads((out / "provenance.json").read_text())
    assert (known["data"]["poses"], known["data"]["test_poses"]) == (720, 180)
    assert known["machine"]["trained_on"] == json.loads(json.dumps(machine.trained_on()))
    assert known["metrics"]["test_rms_percent"] < 0.5
    train_set, test_set = training_and_test_set(3500, machine.robot, 1)
    assert not {tuple(row) for row in train_set.q} & {tuple(row) for row in test_set.q}
    assert main(["rom", "--weights", str(out), "--out", str(tmp_path / "rom")]) == 0
    (out / "samples.csv").write_text(samples.read_text().replace("0.5", "0.6"))
    assert main(["rom", "--weights", str(out), "--out", str(tmp_path / "rom")]) == 2
    assert "samples.csv sha256 = " in capsys.readouterr().err


def test_samples_of_another_robot_are_refused(tmp_path, capsys):
    (tmp_path / "robot.toml").write_text(mechanism_toml({"one": "", "two": ""}, "absent.urdf"))
    for text, words in (
        ("q1_rad,f1_nm\n0.1,3\n0.2,4\n", "2 tables [[axis]], but the robot has 1 axes"),
        (None, "not found"),
    ):
        if text:
            (tmp_path / "samples.csv").write_text(text)
        else:
            (tmp_path / "samples.csv").unlink()
        how = ["--data", str(tmp_path / "samples.csv"), "--out", str(tmp_path / "out")]
        assert main(["train", "--robot", str(tmp_path), *how]) == 2
        complaint = capsys.readouterr().err
        assert complaint.count("\n") == 1
        assert words in complaint
        assert not (tmp_path / "out").exists()
