"""`gravcomp new --from`: what a URDF or MJCF tells stands in robot.toml, what it does not is asked for by name."""

import math
import tomllib

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.robot.machine import load_machine
from gravcomp.robot.mechanism.draft import draft_toml
from mechanisms import WEIGHTS, body, mjcf

ARM = mjcf(
    body("a", 'name="turn" axis="0 0 1"', 4.0, "0.2 0 0", inside=body(
        "b", 'name="lift" axis="0 -1 0" range="-1 2"', 2.5, "0.15 0 0", inside=body(
            "c", 'name="reach" type="slide" axis="1 0 0" range="0.1 0.4"', 1.0
        )
    ))
)  # fmt: skip
ASKED = {
    "clock_hz =": "clock_hz = 40e6",
    "counts_per_turn =": "counts_per_turn = 8192 #",
    "counts_per_m =": "counts_per_m = 1e6 #",
    "effort_per_ampere =": "effort_per_ampere = 5.0 #",
}


@pytest.fixture
def project(tmp_path, capsys):
    (tmp_path / "my arm.xml").write_text(ARM)
    assert main(["new", str(tmp_path / "project"), "--from", str(tmp_path / "my arm.xml")]) == 0
    asked = "clock_hz, counts_per_turn, effort_per_ampere, counts_per_m"
    assert f"give {asked} in weights/mine/robot.toml" in capsys.readouterr().out
    return tmp_path / "project"


def train(machine, capsys) -> str:
    capsys.readouterr()
    assert main(["train", "--robot", str(machine), "--out", str(machine / "out")]) == 2
    assert not (machine / "out").exists()
    return capsys.readouterr().err


def test_axes_ranges_and_units_come_from_the_file_and_the_rest_is_asked_for_by_name(project, capsys):
    machine = project / "weights" / "mine"
    assert (machine / "my arm.xml").read_text() == ARM
    table = tomllib.loads((machine / "robot.toml").read_text())
    assert [axis["joint"] for axis in table["axis"]] == ["turn", "lift", "reach"]
    assert [axis.get("input") for axis in table["axis"]] == ["sin_cos", None, None]
    assert [(axis["low"], axis["high"]) for axis in table["axis"][1:]] == [(-1.0, 2.0), (0.1, 0.4)]
    # Each key that is still missing is named by the next command, until none is.
    for place, (key, value) in (
        ("robot.toml: clock_hz", ("clock_hz =", ASKED["clock_hz ="])),
        ("axis 1: counts_per_turn", ("counts_per_turn =", ASKED["counts_per_turn ="])),
        ("axis 1: effort_per_ampere", ("effort_per_ampere =", ASKED["effort_per_ampere ="])),
        ("axis 3: counts_per_m", ("counts_per_m =", ASKED["counts_per_m ="])),
    ):
        assert f"{place} is missing" in train(machine, capsys)
        assert main(["rom", "--weights", str(machine), "--out", str(project / "rom")]) == 2
        text = (machine / "robot.toml").read_text()
        (machine / "robot.toml").write_text(text.replace(f"#? {key}", value))
    robot = load_machine(machine)
    assert robot.position_units == ("rad", "rad", "m")
    assert (robot.axes[0].low, robot.axes[0].high) == (-math.pi, math.pi)
    assert np.isfinite(robot.robot.forces(robot.robot.workspace(10, 1))).all()


def test_axes_of_a_closed_chain_are_those_with_actuators_or_are_asked_for(tmp_path, capsys):
    text = (WEIGHTS / "fivebar" / "fivebar.xml").read_text()
    (tmp_path / "a.xml").write_text(text)
    assert main(["new", str(tmp_path / "p"), "--from", str(tmp_path / "a.xml")]) == 2
    assert "it has loops, and no actuators say which joints have motors" in capsys.readouterr().err
    assert not (tmp_path / "p").exists()
    drafted = tomllib.loads(draft_toml(tmp_path / "a.xml", ["right", "left"]))
    assert [axis["joint"] for axis in drafted["axis"]] == ["right", "left"]
    assert "held" not in drafted["model"]
    motors = '<actuator><motor joint="left"/><motor joint="right"/></actuator></mujoco>'
    (tmp_path / "a.xml").write_text(text.replace("</mujoco>", motors))
    drafted = tomllib.loads(draft_toml(tmp_path / "a.xml"))
    assert [axis["joint"] for axis in drafted["axis"]] == ["left", "right"]


def test_joints_that_are_no_axes_are_told_to_stand(tmp_path):
    (tmp_path / "a.xml").write_text(ARM)
    drafted = tomllib.loads(draft_toml(tmp_path / "a.xml", ["lift"]))
    assert drafted["model"]["held"] == {"turn": 0.0, "reach": 0.0}


@pytest.mark.parametrize(
    ("axes", "text", "words"),
    [
        ([], None, "not found"),
        ([], mjcf(body("a", 'name="j" axis="0 1 0" range="-1 1"', 0.0)), "joint 'j' moves nothing that has mass"),
        ([], mjcf(body("a", 'name="j" axis="0 1 0"', 1.0, "nan 0 0")), '<inertial> pos="nan 0 0" is not a number'),
        (
            ["--axes", "j"],
            mjcf(
                body("a", 'name="j" axis="0 1 0"', 1.0, inside='<site name="s" pos="0.3 0 0"/>')
                + body("b", 'name="k" axis="0 1 0"', 1.0, pos="1 0 0", inside='<site name="t" pos="0.3 0 0"/>'),
                '<equality><connect site1="s" site2="t"/></equality>',
            ),
            "the loops do not close at the reference pose",
        ),
        (["--axes", "lift,wrist"], ARM, "joint 'wrist' is not known; give one of turn, lift, reach"),
        ([], mjcf("<body/>"), "no joint moves on its own"),
        (
            [],
            mjcf("".join(body(f"b{k}", f'name="j{k}"', 1.0) for k in range(9))),
            "9 joints move, a core has 1 to 8 axes; give --axes of j0, j1",
        ),
    ],
)
def test_file_that_gives_no_robot_is_refused_in_one_line(tmp_path, axes, text, words, capsys):
    if text:
        (tmp_path / "a.xml").write_text(text)
    assert main(["new", str(tmp_path / "p"), "--from", str(tmp_path / "a.xml"), *axes]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert words in complaint
    assert not (tmp_path / "p").exists()
