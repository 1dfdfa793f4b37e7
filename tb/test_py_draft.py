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


LINKS = ("base", "a", "b", "c")


def link(name: str) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def urdf(*joints: str, more: str = "") -> str:
    """A chain of the links base, a, b, c, as long as there are joints: type and what stands in the element, by
    space."""
    chain = "".join(map(link, LINKS[: len(joints) + 1]))
    for parent, child, joint in zip(LINKS, LINKS[1:], joints, strict=False):
        kind, _, inside = joint.partition(" ")
        ends = f'<parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>'
        chain += f'<joint name="to {child}" type="{kind}">{ends}{inside}</joint>'
    return f'<robot name="r">{chain}{more}</robot>'


LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
WIDE = '<limit lower="-6.2832" upper="6.2832" effort="1" velocity="1"/>'


def test_ranges_of_a_urdf_are_asked_for_where_it_has_none_and_its_joints_do_not_turn_for_ever(tmp_path):
    """Revolute needs limits, in the file or not; continuous needs none; two turns show every pose twice."""
    (tmp_path / "a.urdf").write_text(urdf("revolute", "continuous", f"revolute {WIDE}"))
    text = draft_toml(tmp_path / "a.urdf")
    revolute, continuous, wide = text.split("[[axis]]")[1:]
    assert "#? low =" in revolute
    assert "#? high =" in revolute
    assert "sin_cos" not in revolute
    assert "low" not in continuous
    assert 'input = "sin_cos"' in continuous
    assert tomllib.loads(wide)["input"] == "sin_cos"
    assert tomllib.loads(wide)["high"] == 6.2832


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "rad"), ("prismatic", "m")])
@pytest.mark.parametrize("end", ["1e16", "1e30"])
def test_limits_that_stand_for_none_are_asked_for(tmp_path, kind, unit, end):
    (tmp_path / "a.urdf").write_text(urdf(f'{kind} <limit lower="-{end}" upper="{end}" effort="1" velocity="1"/>'))
    text = draft_toml(tmp_path / "a.urdf")
    assert f"#? low =                        # {unit}: the file has no limits" in text
    assert "#? high =" in text


def test_name_space_of_xacro_alone_does_not_make_a_source_of_it(tmp_path):
    text = urdf(f"revolute {LIMIT}").replace('name="r"', 'name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"')
    (tmp_path / "a.urdf").write_text(text)
    assert tomllib.loads(draft_toml(tmp_path / "a.urdf"))["axis"][0]["joint"] == "to a"


XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
FILES = {
    "my arm.urdf.xacro": (f'<robot name="r" {XACRO}><xacro:arm n="a"/></robot>', "> 'my arm.made.urdf'` makes"),
    "value.urdf": (urdf(f"revolute {LIMIT}").replace('value="1"', 'value="${m}"'), "a source for xacro; `xacro "),
    "a.model": (urdf(f"revolute {LIMIT}"), "copy it to a.urdf"),
    "a.sdf": ("<sdf version='1.6'/>", "begins with <sdf>, not with <robot> of a URDF"),
    "two.urdf": (urdf(f"revolute {LIMIT}") * 2, "no XML (junk after document element: line 1"),
    "empty.urdf": ("", "no XML (no element found"),
    "mimic.urdf": (urdf(f"revolute {LIMIT}", f'revolute {LIMIT}<mimic joint="none"/>'),
                   "joint 'to b' mimics 'none', which is no joint that moves"),
    "fixed.urdf": (urdf("fixed", f'revolute {LIMIT}<mimic joint="to a"/>'), "joint 'to b' mimics 'to a'"),
    "loose.urdf": (urdf(f"revolute {LIMIT}", more=link("b")), "links 'base', 'b' hang on no joint, and a URDF has one"),
    "unnamed.xml": (mjcf(body("arm", 'axis="0 1 0" range="-1 1"', 1.0, "0.1 0 0")),
                    "a joint of body 'arm' has no name; give it one"),
    "mesh.xml": (mjcf('<body name="a"><joint name="j"/><geom type="mesh" mesh="m"/></body>',
                      '<asset><mesh name="m" file="m.stl"/></asset>'), "mesh.xml: body 'a' has its mass from a mesh"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_file_of_another_kind_is_told_what_to_make_of_it(name, tmp_path, capsys):
    text, words = FILES[name]
    (tmp_path / name).write_text(text)
    refused(tmp_path / name, words, capsys)


def test_names_that_are_not_utf_8_are_refused_by_line(tmp_path, capsys):
    text = '<?xml version="1.0" encoding="ISO-8859-1"?>\n' + urdf(f"revolute {LIMIT}").replace("to a", "zur Säge")
    (tmp_path / "a.urdf").write_bytes(text.encode("latin-1"))
    refused(tmp_path / "a.urdf", "a.urdf: line 2 is not UTF-8", capsys)


def test_folder_is_no_robot(tmp_path, capsys):
    refused(tmp_path, "not a file; put the URDF or MJCF there, or correct its name", capsys)


def refused(file, words, capsys, axes=()):
    """One line, exit status 2, nothing written."""
    assert main(["new", str(file.parent / "p"), "--from", str(file), *axes]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert words in complaint
    assert not (file.parent / "p").exists()


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
        (["--axes", "lift,lift"], ARM, "joint 'lift' is given twice"),
        (["--axes", "lift,"], ARM, "joint '' is not known; give one of turn, lift, reach"),
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
    refused(tmp_path / "a.xml", words, capsys, axes)
