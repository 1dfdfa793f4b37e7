"""A robot that is a CSV of poses and efforts: its rows are what it knows."""

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.robot.machine import load_machine
from gravcomp.robot.protocol import PoseError
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
