"""Orientations: where the axes go at them, and that one which cannot be is refused in a line before anything moves."""

import json

import numpy as np
import pytest

from gravcomp.errors import InputError
from gravcomp.robot.orientation import positions_at, read_orientations
from gravcomp.robot.protocol import TakesOrientations
from gravcomp.robot.spheiro.kinematics import direct_kinematics
from gravcomp.robot.spheiro.workspace import pose
from gravcomp_lab.shipped import shipped_machine
from support.model_board import ModelBoard
from test_py_campaign import command, limits, one_line  # noqa: F401
from test_py_moving import last_line, mover, run

MACHINE = shipped_machine("spheiro")
D = MACHINE.robot.parameters.d_m
HEADER = "elevation_deg,azimuth_deg,torsion_deg"


def test_torsion_and_tilt_are_those_of_the_papers_angles():
    """q_i = d e_i . (R u_i): a torsion about (1,1,1), and a tilt about (1,-1,0), by Rodrigues' formula."""
    angle = np.deg2rad(13.0)
    cosine, sine = np.cos(angle), np.sin(angle)
    torsion = D * ((1 - cosine) / 3 - sine / np.sqrt(3))
    np.testing.assert_allclose(MACHINE.robot.at_orientation([0.3, 0.0, angle]), [torsion] * 3, atol=1e-15)
    tilt = D * np.array([-(1 - cosine) / 2, -sine / np.sqrt(2), sine / np.sqrt(2)])
    np.testing.assert_allclose(MACHINE.robot.at_orientation([0.0, angle, 0.0]), tilt, atol=1e-15)
    np.testing.assert_array_equal(MACHINE.robot.at_orientation([1.0, 0.0, 0.0]), 0.0)


def test_the_direct_kinematics_leads_back():
    p, rng = MACHINE.robot.parameters, np.random.default_rng(8)
    angles = rng.uniform([0, 0, -p.torsion_max_deg], [360, p.tilt_max_deg, p.torsion_max_deg], (500, 3))
    angles[0] = 350.0, p.tilt_max_deg, -p.torsion_max_deg
    q = positions_at(MACHINE, angles, "test")
    np.testing.assert_allclose(direct_kinematics(q, p), pose(*np.deg2rad(angles).T), atol=1e-9)


def test_the_orientation_at_positions_is_the_one_that_led_there():
    """At the edge of the workspace, too; of a robot without a tilt, its direction is any."""
    robot, rng = MACHINE.robot, np.random.default_rng(9)
    p = robot.parameters
    angles = rng.uniform([-180, 0, -p.torsion_max_deg], [180, p.tilt_max_deg, p.torsion_max_deg], (500, 3))
    angles[0] = 170.0, p.tilt_max_deg, -p.torsion_max_deg
    told = np.rad2deg(robot.orientation(positions_at(MACHINE, angles, "test")))
    tilted = angles[:, 1] > 1.0
    np.testing.assert_allclose(told[tilted], angles[tilted], atol=1e-6)
    np.testing.assert_allclose(told[:, 1:], angles[:, 1:], atol=1e-6)
    np.testing.assert_allclose(robot.orientation(robot.at_orientation([0.7, 0.0, 0.1]))[1:], [0.0, 0.1], atol=1e-9)


@pytest.mark.parametrize(
    ("angles", "words"),
    [
        ([0.0, 35.1, 0.0], "x: pose 1 is outside the workspace; give an azimuth from 0 to 35, a torsion of 20"),
        ([0.0, -1.0, 0.0], "outside the workspace"),
        ([0.0, 0.0, -20.1], "outside the workspace"),
        ([0.0, 0.0], "x: need elevation, azimuth, torsion, a number of degrees each"),
        ([0.0, 0.0, np.nan], "a number of degrees each"),
    ],
)  # fmt: skip
def test_orientation_that_cannot_be_is_refused(angles, words):
    with pytest.raises(InputError, match=words):
        positions_at(MACHINE, np.array(angles), "x")


def test_robot_without_orientations_says_so(tmp_path):
    slide = shipped_machine("slide")
    assert not isinstance(slide.robot, TakesOrientations)
    with pytest.raises(InputError, match="takes no orientations; give positions of its axes"):
        positions_at(slide, np.zeros(3), "x")
    with pytest.raises(InputError, match="takes no orientations; leave --orientations out"):
        read_orientations(tmp_path / "x.csv", slide)


def test_move_goes_to_orientations_and_positions_in_their_order(limits, tmp_path):  # noqa: F811
    model_core = mover()
    poses = ("--orient", "30", "20", "-10", "--to", "0.01", "0", "0", "--orientation", "0", "0", "0")
    with ModelBoard(model_core) as model:
        assert run(model, "move", limits, *poses, "--seconds", "0.1", "--hold", "0") == 0
    expected = MACHINE.drive.counts(positions_at(MACHINE, np.array([30.0, 20.0, -10.0]), "")).tolist()
    assert np.abs(expected).max() > 10_000
    assert model_core.targets == [[n % 2**32 for n in expected], [10_000, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--orientation", "0", "80", "0"), "--orientation 0 80 0: pose 1 is outside the workspace; give an azimuth"),
        (("--orientation", "0", "8"), "--orientation 0 8: need elevation, azimuth, torsion"),
        ((), "no pose to move to; give --to or --orientation"),
    ],
)
def test_poses_that_cannot_be_are_refused_before_anything_moves(arguments, words, limits, capsys):  # noqa: F811
    model_core = mover()
    with ModelBoard(model_core) as model:
        assert run(model, "move", limits, *arguments) == 2
    assert words in last_line(capsys)
    assert (model_core.moves, model_core.get("control") & 1) == (0, 0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "its header is missing; give elevation_deg,azimuth_deg,torsion_deg"),
        ("a,b,c\n1,2,3\n", "its header is a,b,c; give"),
        (HEADER + "\n1,2\n", "row 1: need 3 finite numbers"),
        (HEADER + "\n1,2,3\n1,x,3\n", "row 2: need 3 finite numbers"),
        (HEADER + "\n1,2,3\n1,36,3\n", "pose 2 is outside the workspace"),
        (HEADER + "\n1,2,3\n", "1 poses and 8 legs: need 8 and 2 at least"),
    ],
)
def test_file_of_orientations_that_cannot_be_is_one_line(text, words, limits, tmp_path, capsys):  # noqa: F811
    file = tmp_path / "orientations.csv"
    file.write_text(text)
    with ModelBoard(mover()) as board:
        assert command(board, limits, tmp_path / "out", "--orientations", str(file)) == 2
    assert words in one_line(capsys)
    assert not (tmp_path / "out").exists()


def test_campaign_holds_the_orientations_of_its_file(limits, tmp_path, monkeypatch, capsys):  # noqa: F811
    rng, out, file = np.random.default_rng(4), tmp_path / "out", tmp_path / "orientations.csv"
    angles = np.column_stack([rng.uniform(0, 360, 9), rng.uniform(0, 30, 9), rng.uniform(-15, 15, 9)]).round(3)
    lines = [",".join(f"{x:g}" for x in row) for row in angles]
    file.write_text("\n".join(["# nine", HEADER, *lines]) + "\n")
    seen = []
    monkeypatch.setattr("gravcomp.commands.campaign.conduct", lambda campaign, *_: seen.append(campaign))
    with ModelBoard(mover()) as board:
        assert command(board, limits, out, "--orientations", str(file)) == 0
        assert command(board, limits, out, "--orientations", str(file), "--resume") == 0
        assert command(board, limits, out, "--poses", "9", "--resume") == 2
    assert "orientations is" in one_line(capsys)
    for campaign in seen:
        entries = campaign.plan.entries()
        assert entries == json.loads(json.dumps(entries)), "campaign.json says what its reader gets"
        holds = np.array([step.pose for step in campaign.steps if step.kind == "hold"])
        np.testing.assert_allclose(holds, MACHINE.drive.counts(positions_at(MACHINE, angles, "")), atol=1)
    assert json.loads((out / "plan.json").read_text())["orientations"] == angles.tolist()
