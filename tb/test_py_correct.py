"""What a diagnosis found goes back into the robot's file, and MuJoCo holds the robot with the efforts that follow."""

import mujoco
import numpy as np
import pytest

from gravcomp.cli import main
from mechanisms import WEIGHTS, body, mechanism_toml, mjcf

G = 9.81
EFFECTS = """
[[effects]]
name = "payload"
params = {mass = 0.5, moment_x = 0.04, moment_y = 0.0, moment_z = -0.02}
[[effects]]
name = "body_moment"
params = {moment_upper_arm_x = 0.3, moment_upper_arm_z = -0.1}
[[effects]]
name = "coulomb_friction"
params = {fc_1 = 0.8, fc_pos_2 = 0.5, fc_neg_2 = 0.3}
[[effects]]
name = "viscous_friction"
params = {b_1 = 2.0}
[[effects]]
name = "inertia"
params = {m_2 = 0.03}
[[effects]]
name = "cable_spring"
params = {k_2 = 0.6, q0_2 = 0.2}
[[effects]]
name = "encoder_offset"
params = {offset_1 = 0.01}
"""


def corrected(folder, effects, machine="arm2", name="arm2.xml", status=0):
    for path in (WEIGHTS / machine).glob("*.xml"):
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "model.toml").write_text((WEIGHTS / machine / "robot.toml").read_text() + effects)
    assert main(["correct", str(folder / "model.toml"), "--out", str(folder / f"new_{name}")]) == status
    return folder / f"new_{name}"


def held(model, q):
    """Efforts of MuJoCo's inverse dynamics at rest."""
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_inverse(model, data)
    return data.qfrc_inverse


def test_engine_holds_an_arm_with_what_was_found(tmp_path, capsys):
    path = corrected(tmp_path, EFFECTS)
    new, old = (mujoco.MjModel.from_xml_path(str(p)) for p in (path, WEIGHTS / "arm2" / "arm2.xml"))
    for q1, q2 in ((0.3, -0.5), (1.2, 0.7), (-0.2, 1.9)):
        elbow = 0.04 * np.cos(q1 + q2) + 0.02 * np.sin(q1 + q2) + 0.5 * 0.3 * np.cos(q1 + q2)
        shoulder = 0.5 * 0.4 * np.cos(q1) + 0.3 * np.cos(q1) + 0.1 * np.sin(q1)
        expected = held(old, [q1, q2]) + G * np.array([shoulder + elbow, elbow]) + [0.0, 0.6 * (q2 - 0.2)]
        np.testing.assert_allclose(held(new, [q1, q2]), expected, atol=1e-9)
    np.testing.assert_allclose(new.dof_frictionloss, [0.8, 0.4])
    np.testing.assert_allclose(new.dof_damping, [2.0, 0.0])
    np.testing.assert_allclose(new.dof_armature, [0.0, 0.03])
    said = capsys.readouterr().out
    assert "left out, such a file has no place for: encoder_offset" in said
    assert "joint shoulder: frictionloss 0 -> 0.8" in said
    assert path.read_text().startswith("<!-- An arm of two links")


def test_tilted_base_is_gravity_of_the_file(tmp_path, capsys):
    tilt = '\n[[effects]]\nname = "base_tilt"\nparams = {tilt_a = 0.03, tilt_b = -0.02}\n'
    gravity = mujoco.MjModel.from_xml_path(str(corrected(tmp_path, tilt))).opt.gravity
    assert np.linalg.norm(gravity) == pytest.approx(G)
    assert np.arccos(-gravity[2] / G) == pytest.approx(np.hypot(0.03, 0.02), rel=1e-3)
    assert "robot.toml: [model] gravity = [" in capsys.readouterr().out


def test_friction_of_passive_joints_goes_to_the_joints_of_the_loop(tmp_path):
    friction = '\n[[effects]]\nname = "passive_joint_friction"\nparams = {fc_rotary_nm = 0.1, fc_rotary_nm_2 = 0.05}\n'
    model = mujoco.MjModel.from_xml_path(str(corrected(tmp_path, friction, "fivebar", "fivebar.xml")))
    found = {model.joint(k).name: model.dof_frictionloss[model.jnt_dofadr[k]] for k in range(model.njnt)}
    assert found == pytest.approx({"left": 0.0, "right": 0.0, "elbow_left": 0.1, "elbow_right": 0.15})


URDF = """<robot name="r">
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="flange"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="0.5" friction="0.1"/></joint>
  <joint name="f" type="fixed"><parent link="arm"/><child link="flange"/><origin xyz="0.5 0 0" rpy="0 0 0"/></joint>
</robot>"""


def urdf_model(folder, effects):
    (folder / "r.urdf").write_text(URDF)
    text = mechanism_toml({"a": ""}, "r.urdf", 'payload_body = "flange"')
    (folder / "model.toml").write_text(text + effects)
    return folder / "model.toml"


def test_urdf_takes_masses_friction_and_damping(tmp_path):
    """A moment of 0.1 kg m and 1 kg on a flange without mass, 0.5 m out: with the arm 0.4 + 0.5 + 0.1 kg m."""
    model = urdf_model(tmp_path, '[[effects]]\nname = "payload"\nparams = {mass = 1.0, moment_x = 0.1}\n'
                       '[[effects]]\nname = "coulomb_friction"\nparams = {fc_1 = 0.3}\n'
                       '[[effects]]\nname = "viscous_friction"\nparams = {b_1 = 0.25}\n')  # fmt: skip
    out = tmp_path / "new.urdf"
    assert main(["correct", str(model), "--out", str(out)]) == 0
    new = mujoco.MjModel.from_xml_path(str(out))
    for q in (0.0, 0.6):
        assert held(new, [q])[0] == pytest.approx(G * 1.0 * np.cos(q), rel=1e-9)
    assert (new.dof_frictionloss[0], new.dof_damping[0]) == pytest.approx((0.3, 0.25))
    assert new.body_mass.sum() == pytest.approx(3.0)


LOSSES = """
[[effects]]
name = "coulomb_friction"
params = {fc_1 = 0.8, fc_2 = 0.4}
[[effects]]
name = "viscous_friction"
params = {b_1 = 2.0}
[[effects]]
name = "inertia"
params = {m_2 = 0.03}
"""


@pytest.mark.parametrize("file", ["r.urdf", "robot.xml"])
def test_joint_is_not_taken_for_another_element_of_its_name(file, tmp_path):
    """A transmission of a URDF, an equality of an MJCF, each before the joint itself."""
    if file == "r.urdf":
        before = '<transmission name="t"><joint name="a"><hardwareInterface/></joint></transmission>'
        text = URDF.replace('<link name="base"/>', before + '<link name="base"/>')
    else:
        one, two = (body(name, f'name="{name}" axis="0 -1 0" range="-1 1"', 1.0, "0.3 0 0") for name in "ab")
        equality = '<equality><joint name="a" joint1="a" joint2="b"/></equality>'
        text = mjcf(one + two).replace("<worldbody>", equality + "<worldbody>")
    (tmp_path / file).write_text(text)
    friction = '[[effects]]\nname = "coulomb_friction"\nparams = {fc_1 = 0.3}\n'
    (tmp_path / "model.toml").write_text(mechanism_toml({"a": ""}, file) + friction)
    assert main(["correct", str(tmp_path / "model.toml"), "--out", str(tmp_path / f"new_{file}")]) == 0
    new = mujoco.MjModel.from_xml_path(str(tmp_path / f"new_{file}"))
    assert new.dof_frictionloss[new.joint("a").dofadr[0]] == pytest.approx(0.3)


def test_friction_found_again_with_the_corrected_file_is_not_added_twice(tmp_path):
    """No effort of the model depends on a file's friction, damping or armature: a log shows all of them once more."""
    once = corrected(tmp_path, LOSSES)
    again = tmp_path / "again"
    again.mkdir()
    (again / "arm2.xml").write_text(once.read_text())
    (again / "model.toml").write_text((WEIGHTS / "arm2" / "robot.toml").read_text() + LOSSES)
    assert main(["correct", str(again / "model.toml"), "--out", str(again / "new.xml")]) == 0
    assert (again / "new.xml").read_text() == once.read_text()


def test_mass_that_geoms_give_is_written_out(tmp_path):
    joint, geom = '<joint name="a" axis="0 -1 0" range="-1 1"/>', '<geom size="0.1" pos="0.3 0 0" mass="2"/>'
    world = f'<body name="b">{joint}{geom}</body>'
    (tmp_path / "robot.xml").write_text(mjcf(world))
    effect = '[[effects]]\nname = "payload"\nparams = {moment_x = 0.1}\n'
    (tmp_path / "model.toml").write_text(mechanism_toml({"a": ""}) + effect)
    assert main(["correct", str(tmp_path / "model.toml"), "--out", str(tmp_path / "new.xml")]) == 0
    new = mujoco.MjModel.from_xml_path(str(tmp_path / "new.xml"))
    assert held(new, [0.0])[0] == pytest.approx(G * 0.7, rel=1e-9)
    assert new.body("b").inertia == pytest.approx([0.4 * 2 * 0.01] * 3)


REFUSED = {
    "nothing found": ("", "nothing in it that a URDF or MJCF can have"),
    "only of the encoder": ('[[effects]]\nname = "encoder_offset"\nparams = {offset_1 = 0.1}\n', "nothing in it that"),
    "below no friction": ('[[effects]]\nname = "coulomb_friction"\nparams = {fc_1 = -1.0}\n', "cannot be negative"),
    "more than its mass": ('[[effects]]\nname = "payload"\nparams = {mass = -2.5}\n', "would have the mass"),
    "spring": ('[[effects]]\nname = "cable_spring"\nparams = {k_1 = 1.0, q0_1 = 0.0}\n', "a URDF has no springs"),
    "armature": ('[[effects]]\nname = "inertia"\nparams = {m_1 = 1.0}\n', "a URDF has no armature"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_file_that_cannot_have_it_is_refused_in_one_line(tmp_path, capsys, case):
    effects, said = REFUSED[case]
    out = tmp_path / "new.urdf"
    assert main(["correct", str(urdf_model(tmp_path, effects)), "--out", str(out)]) == 2
    message = capsys.readouterr().err
    assert said in message
    assert len(message.splitlines()) == 1
    assert not out.exists()


def test_robot_of_no_file_is_refused(tmp_path, capsys):
    assert main(["correct", str(WEIGHTS / "spheiro" / "robot.toml"), "--out", str(tmp_path / "x.xml")]) == 2
    assert "its robot is of no file" in capsys.readouterr().err


def test_body_of_an_included_file_is_refused(tmp_path, capsys):
    part = body("b", 'name="a" axis="0 -1 0" range="-1 1"', 1.0, "0.3 0 0")
    (tmp_path / "part.xml").write_text(f"<mujoco>{part}</mujoco>")
    (tmp_path / "robot.xml").write_text(mjcf('<include file="part.xml"/>'))
    effect = '[[effects]]\nname = "payload"\nparams = {moment_x = 0.1}\n'
    (tmp_path / "model.toml").write_text(mechanism_toml({"a": ""}) + effect)
    assert main(["correct", str(tmp_path / "model.toml"), "--out", str(tmp_path / "new.xml")]) == 2
    assert "stands in a file that it includes" in capsys.readouterr().err
