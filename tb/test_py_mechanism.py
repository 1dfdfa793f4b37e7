"""Robots of URDF and MJCF files: efforts by formulas written here, by the gradient of the energy, by MuJoCo itself."""

import json
import os
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.core.formats import quantise
from gravcomp.network.weights import load_network
from gravcomp.prototype.body import prototype_mjcf
from gravcomp.robot.machine import load_machine
from gravcomp.robot.protocol import HasPassiveJoints, PoseError
from gravcomp.training.training import N_TEST_POSES, workspace_set
from gravcomp.twin.network import core
from gravcomp.twin.precision import MAX_SHARE, WHOLE_MN
from machines import MACHINE, P
from mechanisms import SHIPPED_MECHANISMS, WEIGHTS, body, mechanism, mjcf, write_mechanism

G = 9.81
ROBOTS = [os.environ.get("GRAVCOMP_DATA"), Path(__file__).resolve().parents[2] / "shared" / "data"]
LINEAR = "counts_per_m = 1000000\n"
CARRIAGES = {f"carriage{k}": f"{LINEAR}low = -0.161\nhigh = 0.161" for k in (1, 2, 3)}
ARM = mjcf(
    body("a", 'name="one" axis="0 -1 0" range="-3 3"', 4.0, "0.2 0 0.03", inside=body(
        "b", 'name="two" axis="0 -1 0" range="-2 2"', 2.5, "0.15 0 -0.02", "0.4 0 0"
    ))
)  # fmt: skip
TWO = {"one": "", "two": ""}


def gradient(robot, q, step=1e-6):
    """dV/dq (N, n) by central differences."""
    units = step * np.eye(robot.n_axes)
    return np.stack([(robot.energy(q + u) - robot.energy(q - u)) / (2 * step) for u in units], axis=-1)


@pytest.fixture(scope="module")
def spheiro(tmp_path_factory):
    """The Sphe.I.Ro. as MJCF: legs of five joints, a free platform, welds."""
    return mechanism(tmp_path_factory.mktemp("spheiro"), prototype_mjcf(P), CARRIAGES).robot


def test_planar_arm_has_the_efforts_of_its_formula(tmp_path):
    robot = mechanism(tmp_path, ARM, TWO).robot
    q = robot.workspace(500, 1)
    first, both = q[:, 0], q.sum(axis=1)
    fore = 2.5 * G * (0.15 * np.cos(both) + 0.02 * np.sin(both))
    upper = 4.0 * G * (0.2 * np.cos(first) - 0.03 * np.sin(first)) + 2.5 * G * 0.4 * np.cos(first)
    np.testing.assert_allclose(robot.forces(q), np.stack([upper + fore, fore], axis=1), atol=1e-9)
    assert robot.position_units == ("rad", "rad")


@pytest.mark.parametrize(("gravity", "held"), [("[0.0, 0.0, -9.81]", 1.0), ("[0.0, 9.81, 0.0]", 0.0)])
def test_vertical_slide_bears_its_weight_and_spring_whatever_its_mounting(tmp_path, gravity, held):
    text = mjcf(body("a", 'name="z" type="slide" axis="0 0 1" range="0 0.5" stiffness="120" springref="0.7"', 14.0))
    robot = mechanism(tmp_path, text, {"z": LINEAR}, model=f"gravity = {gravity}").robot
    q = robot.workspace(100, 1)
    np.testing.assert_allclose(robot.forces(q), held * 14.0 * G + 120.0 * (q - 0.7), atol=1e-9)
    assert robot.position_units == ("m",)


def test_mixed_axes_and_joints_at_an_offset_have_the_efforts_of_their_formula(tmp_path):
    """A slide that leans by 30 degrees carries a hinge whose axis does not pass through the body's origin."""
    lean = np.deg2rad(30)
    text = mjcf(body("a", f'name="s" type="slide" axis="{np.sin(lean)} 0 {np.cos(lean)}" range="0 1"', 3.0, inside=body(
        "b", 'name="h" axis="0 1 0" pos="0.1 0 0" range="-9 9"', 2.0, "0.4 0 0"
    )))  # fmt: skip
    robot = mechanism(tmp_path, text, {"s": LINEAR, "h": ""}).robot
    q = robot.workspace(100, 1)
    wanted = np.stack([np.full(100, 5.0 * G * np.cos(lean)), -2.0 * G * 0.3 * np.cos(q[:, 1])], axis=1)
    np.testing.assert_allclose(robot.forces(q), wanted, atol=1e-9)


def test_spheiro_as_a_closed_chain_has_the_forces_of_its_closed_form(spheiro):
    q = MACHINE.robot.workspace(200, 3)
    error_n = np.abs(spheiro.forces(q) - MACHINE.robot.forces(q)).max()
    print(f"MEASURED closed chain off the closed form by {error_n:.2g} N")
    assert error_n < 0.02


def test_passive_joints_of_the_spheiro_move_as_in_its_closed_form(spheiro):
    q = MACHINE.robot.workspace(20, 4)
    names = [spheiro.tree.joints[joint] for joint in spheiro._simple_joints[1]]
    rows = [names.index(f"{joint}{k}") for joint in ("slide", "turn") for k in (1, 2, 3)]
    np.testing.assert_allclose(spheiro.passive_jacobian(q)[:, rows], MACHINE.robot.passive_jacobian(q), atol=1e-8)


@pytest.mark.parametrize("name", SHIPPED_MECHANISMS)
def test_efforts_of_a_shipped_machine_are_the_gradient_of_its_energy(name):
    robot = load_machine(WEIGHTS / name).robot
    q = robot.workspace(100, 5)
    np.testing.assert_allclose(robot.forces(q), gradient(robot, q), atol=1e-6)


def test_efforts_of_the_spheiro_as_closed_chain_are_the_gradient_of_its_energy(spheiro):
    q = MACHINE.robot.workspace(20, 6)
    np.testing.assert_allclose(spheiro.forces(q), gradient(spheiro, q), atol=1e-5)


@pytest.mark.parametrize("name", ["ur5", "so101"])
def test_a_serial_chain_has_the_gravity_terms_of_mujoco(name):
    import mujoco

    robot = load_machine(WEIGHTS / name).robot
    model, q = robot.tree.model, robot.workspace(50, 7)
    data, wanted = mujoco.MjData(model), []
    for row in q:
        data.qpos[:] = row
        mujoco.mj_forward(model, data)
        wanted.append(data.qfrc_bias.copy())
    np.testing.assert_allclose(robot.forces(q), wanted, atol=1e-9)


def fivebar_elbows(q):
    """Tip and elbows (N, 2) of the shipped five-bar: the upper crossing of two circles about the elbows."""
    left = np.deg2rad(135) + q[:, 0]
    right = np.deg2rad(45) + q[:, 1]
    one = np.stack([-0.1 + 0.25 * np.cos(left), 0.25 * np.sin(left)], axis=1)
    two = np.stack([0.1 + 0.25 * np.cos(right), 0.25 * np.sin(right)], axis=1)
    across = two - one
    half = np.linalg.norm(across, axis=1) / 2
    normal = np.stack([-across[:, 1], across[:, 0]], axis=1) / (2 * half)[:, None]
    return (one + two) / 2 + np.sqrt(0.45**2 - half**2)[:, None] * normal, one, two


def test_five_bar_keeps_its_assembly_mode_over_its_whole_range():
    """Its energy is that of the crossing above, to the corners of the range."""
    robot = load_machine(WEIGHTS / "fivebar").robot
    q = np.concatenate([robot.workspace(300, 8), [[-0.7, 0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, -0.7]]])
    tip, one, two = fivebar_elbows(q)
    base = np.array([[-0.1, 0.0], [0.1, 0.0]])
    cranks = 1.2 * sum(b + 0.1 / 0.25 * (e - b) for b, e in zip(base, (one, two), strict=True))
    rods = 0.8 * sum(e + 0.2 / 0.45 * (tip - e) for e in (one, two))
    np.testing.assert_allclose(robot.energy(q), G * (cranks + rods + 1.5 * tip)[:, 1], atol=1e-9)


def test_poses_that_a_five_bar_cannot_take_are_refused_by_number():
    robot = load_machine(WEIGHTS / "fivebar").robot
    # Cranks outward until the elbows are farther apart than the rods are long, by symmetry: a singular stretch first.
    with pytest.raises(PoseError, match=r"^pose 3: the loops do not close at \(3.1, -3.1\)") as refused:
        robot.forces(np.array([[0.1, 0.0], [0.0, 0.2], [3.1, -3.1]]))
    assert refused.value.index == 2
    with pytest.raises(PoseError, match="pose 2 is not a number"):
        robot.forces(np.array([[0.1, 0.0], [np.nan, 0.0]]))


def test_stretched_four_bar_is_refused_at_its_singularity_and_held_before_it(tmp_path):
    """Crank 0.5 m, coupler and rocker 0.4 m, base 1 m: the rocker is stretched where cos(crank) = 0.61."""
    crank = body("crank", 'name="crank" axis="0 -1 0" range="-9 9"', 1.0, "0.25 0 0", inside=body(
        "coupler", 'name="knee" axis="0 -1 0"', 1.0, "0.2 0 0", "0.5 0 0", '<site name="end" pos="0.4 0 0"/>'
    ))  # fmt: skip
    rocker = body("rocker", 'name="rocker" axis="0 -1 0"', 1.0, "0.2 0 0", "1 0 0", '<site name="tip" pos="0.4 0 0"/>')
    closing = '<equality><connect site1="end" site2="tip"/></equality>'
    # The coupler from the crank's end (0.5, 0) to the crossing at (0.75, 0.3122): knee up, rocker leaning back.
    up = np.arccos(0.25 / 0.4)
    key = f'<keyframe><key qpos="0 {up} {np.pi - up}"/></keyframe>'
    robot = mechanism(tmp_path, mjcf(crank + rocker, closing + key), {"crank": "low = -0.9\nhigh = 0.9"}).robot
    stretched = np.arccos((1 + 0.25 - 0.64) / 1.0)
    assert np.isfinite(robot.forces(np.array([[stretched - 1e-4], [1e-4 - stretched]]))).all()
    for beyond in (stretched, stretched + 1e-4, 1.5):
        with pytest.raises(PoseError, match=r"^pose 1: .* reach a singularity, or their end, after \d+ %"):
            robot.forces(np.array([beyond]))


def test_mimic_joints_follow_and_other_joints_stand_where_they_are_held(tmp_path):
    """A gripper of two fingers, one mimicking the other: as an axis it bears both; left out, it stands."""
    links = '<link name="base"/>' + "".join(
        f'<link name="{n}"><inertial><origin xyz="0.1 0 0"/><mass value="{m}"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for n, m in (("arm", 2.0), ("left", 0.5), ("right", 0.5))
    )

    def joint(name, kind, parent, child, axis, more=""):
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
            f'<limit lower="-1" upper="1" effort="1" velocity="1"/>{more}</joint>'
        )

    mimic = '<mimic joint="left_joint" multiplier="-2" offset="0"/>'
    urdf = f"""<robot name="r">{links}{joint("turn", "revolute", "base", "arm", "0 -1 0")}
    {joint("left_joint", "prismatic", "arm", "left", "1 0 0")}
    {joint("right_joint", "prismatic", "arm", "right", "1 0 0", mimic)}</robot>"""
    both = mechanism(tmp_path / "both", urdf, {"turn": "", "left_joint": LINEAR}, "r.urdf").robot
    q = both.workspace(50, 9)
    x = 2.0 * 0.1 + 0.5 * (0.1 + q[:, 1]) + 0.5 * (0.1 - 2 * q[:, 1])
    wanted = G * np.stack([x * np.cos(q[:, 0]), (0.5 - 2 * 0.5) * np.sin(q[:, 0])], axis=1)
    np.testing.assert_allclose(both.forces(q), wanted, atol=1e-9)
    held = "[model.held]\nleft_joint = 0.2\nright_joint = -0.4"
    alone = mechanism(tmp_path / "alone", urdf, {"turn": ""}, "r.urdf", held).robot
    x = 2.0 * 0.1 + 0.5 * 0.3 + 0.5 * (0.1 - 0.4)
    np.testing.assert_allclose(alone.forces(q[:, :1]), G * x * np.cos(q[:, :1]), atol=1e-9)


def test_moment_on_a_body_adds_what_a_heavier_body_bears(tmp_path):
    """A mass at the body's origin moved by r, against one that stays there: the difference is the moment m r."""
    robot = mechanism(tmp_path / "plain", ARM, TWO).robot
    q, m, r = robot.workspace(30, 10), 0.7, np.array([0.05, -0.02, 0.11])
    for number, (name, inertial) in enumerate((("a", '"0.2 0 0.03" mass="4.0"'), ("b", '"0.15 0 -0.02" mass="2.5"'))):
        assert robot.body_names[number] == name
        centre, mass = (np.array(part.split(), dtype=float) for part in inertial.split('"')[1::2])
        moved = [
            f'"{" ".join(map(str, (mass * centre + m * place) / (mass + m)))}" mass="{mass[0] + m}"'
            for place in (r, 0 * r)
        ]
        with_moment, without = (
            mechanism(tmp_path / f"{name}{k}", ARM.replace(inertial, new), TWO).robot for k, new in enumerate(moved)
        )
        wanted = with_moment.forces(q) - without.forces(q)
        np.testing.assert_allclose(robot.moment_regressors(q)[..., number, :] @ (m * r), wanted, atol=1e-9)
    np.testing.assert_allclose(robot.payload_regressors(q), robot.moment_regressors(q)[..., -1, :])


def test_turned_gravity_is_that_of_a_base_mounted_so():
    robot = load_machine(WEIGHTS / "arm2").robot
    q, turn = robot.workspace(20, 11), 0.3
    leaning = robot.with_gravity(np.array([-np.sin(turn), 0.0, -np.cos(turn)]))
    np.testing.assert_allclose(leaning.forces(q), robot.forces(q + np.array([turn, 0.0])), atol=1e-9)


def test_bounds_hold_all_efforts_of_the_range_and_little_more():
    robot = load_machine(WEIGHTS / "ur5").robot
    f = robot.forces(robot.workspace(60000, 12))
    assert (f <= robot.bounds.f_high + 1e-12).all()
    assert (f >= robot.bounds.f_low - 1e-12).all()
    assert robot.bounds.f_high[1] < 1.03 * f[:, 1].max()


@pytest.mark.parametrize("name", ["ur5_robot", "so101", "panda", "xarm7"])
def test_published_urdf_loads_without_its_meshes(tmp_path, name):
    found = [folder for folder in ROBOTS if folder and (Path(folder) / "robots" / f"{name}.urdf").exists()]
    if not found:
        pytest.skip(f"{name}.urdf is neither in ../shared/data/robots nor in GRAVCOMP_DATA")
    text = (Path(found[0]) / "robots" / f"{name}.urdf").read_text()
    joints = [j.get("name") for j in ElementTree.fromstring(text).iter("joint") if j.get("type") == "revolute"]
    robot = mechanism(tmp_path, text, {joint: "" for joint in joints[:7]}, f"{name}.urdf").robot
    q = robot.workspace(2000, 13)
    f = robot.forces(q)
    assert np.isfinite(f).all()
    shipped = WEIGHTS / name.removesuffix("_robot")
    if shipped.exists():  # written here with the numbers of the URDF
        order = [joints.index(axis.name) for axis in load_machine(shipped).axes]
        written = load_machine(shipped).robot.forces(q[:, order])
        np.testing.assert_allclose(written, f[:, order], atol=1e-5 * np.abs(f).max())
    assert np.abs(f).max() > 0.5
    assert not isinstance(robot, HasPassiveJoints)


# A delta: hips R from the middle, arms L, rods of length ROD, platform joints R_PLATFORM from its middle; m and kg. The
# two bars of each parallelogram are one rod along their middle, as the platform does not turn.
R, L, ROD, R_PLATFORM, ARM_CENTRE, ROD_CENTRE = 0.2, 0.25, 0.6, 0.05, 0.11, 0.35
ARM_KG, ROD_KG, PLATFORM_KG = 0.9, 0.4, 1.3
LEG_RAD = 2 * np.pi * np.arange(3) / 3


def delta_mjcf() -> str:
    """At zero the arms are level. Motors turn them down; the platform slides along x, y, z, held by three rods."""
    out = R + L - R_PLATFORM
    height = np.sqrt(ROD**2 - out**2)
    legs = sites = ties = ""
    for k, angle in enumerate(LEG_RAD):
        rod = (
            f'<body name="rod{k}" pos="{L} 0 0" euler="0 {np.arctan2(height, -out)} 0"><joint axis="0 1 0"/>'
            f'<joint axis="0 0 1"/><inertial pos="{ROD_CENTRE} 0 0" mass="{ROD_KG}" diaginertia="1e-3 1e-3 1e-3"/>'
            f'<site name="tip{k}" pos="{ROD} 0 0"/></body>'
        )
        hip = R * np.cos(angle), R * np.sin(angle)
        legs += (
            f'<body name="arm{k}" pos="{hip[0]} {hip[1]} 0" euler="0 0 {angle}">'
            f'<joint name="motor{k}" axis="0 1 0" range="-0.6 0.8"/>'
            f'<inertial pos="{ARM_CENTRE} 0 0" mass="{ARM_KG}" diaginertia="1e-3 1e-3 1e-3"/>{rod}</body>'
        )
        sites += f'<site name="at{k}" pos="{R_PLATFORM * np.cos(angle)} {R_PLATFORM * np.sin(angle)} 0"/>'
        ties += f'<connect site1="tip{k}" site2="at{k}"/>'
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    platform = f'<inertial pos="0 0 0" mass="{PLATFORM_KG}" diaginertia="1e-3 1e-3 1e-3"/>'
    world = f'{legs}<body name="platform" pos="0 0 {-height}">{slides}{platform}{sites}</body>'
    return mjcf(world, f"<equality>{ties}</equality>")


def delta_efforts(q):
    """Torques (n, 3), Nm, that hold a delta at motor angles q (n, 3), rad: the gradient of its potential energy.

    Its platform p is where three spheres of radius ROD about c_k meet, below them; (p - c_k) (dp - dc_k) = 0 gives dp.
    """
    outward = np.stack([np.cos(LEG_RAD), np.sin(LEG_RAD), 0 * LEG_RAD], axis=1)
    z = np.array([0.0, 0.0, 1.0])
    along = np.cos(q)[..., None] * outward - np.sin(q)[..., None] * z
    across = -np.sin(q)[..., None] * outward - np.cos(q)[..., None] * z
    c = (R - R_PLATFORM) * outward + L * along
    u, v = c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]
    normal = np.cross(u, v)
    square = np.sum(normal**2, axis=1, keepdims=True)
    centre = np.cross(np.sum(u**2, 1, keepdims=True) * v - np.sum(v**2, 1, keepdims=True) * u, normal) / (2 * square)
    down = -np.sign(normal[:, 2:]) * np.sqrt((ROD**2 - np.sum(centre**2, 1, keepdims=True)) / square)
    p = c[:, 0] + centre + down * normal
    rods = p[:, None] - c
    platform = np.linalg.solve(rods, np.eye(3) * L * np.sum(rods * across, axis=2)[:, None])[:, 2]
    part = ROD_CENTRE / ROD
    arm = (ARM_KG * ARM_CENTRE + ROD_KG * (1 - part) * L) * across[..., 2]
    return G * (arm + (3 * ROD_KG * part + PLATFORM_KG) * platform)


def test_delta_of_three_motors_is_held_by_the_closed_form(tmp_path):
    machine = mechanism(tmp_path, delta_mjcf(), {f"motor{k}": "" for k in range(3)})
    q = machine.robot.workspace(300, 21)
    np.testing.assert_allclose(machine.robot.forces(q), delta_efforts(q), atol=1e-8)


def test_bodies_without_inertial_weigh_what_their_simple_geoms_do(tmp_path):
    text = mjcf(
        '<body><joint name="j" axis="0 -1 0" range="-1 1"/><geom type="sphere" size="0.1" pos="0.3 0 0" mass="2"/>'
        '<geom type="mesh" mesh="shell" mass="0"/></body>',
        '<asset><mesh name="shell" file="not_there.stl"/></asset>',
    )
    robot = mechanism(tmp_path, text, {"j": ""}).robot
    np.testing.assert_allclose(robot.forces(np.array([0.4])), [2 * G * 0.3 * np.cos(0.4)], atol=1e-9)


HINGE = 'name="j" axis="0 1 0"'
ONE = mjcf(body("a", HINGE + ' range="-1 1"', 1.0, "0.1 0 0"))
LOOP = body("a", HINGE + ' range="-1 1"', 1.0, "0.1 0 0", "0 0 0", '<site name="s" pos="0.3 0 0"/>')
# Robot file, more of [[axis]] by joint, and words of the one line that each ends in.
BAD = {
    "joint unknown": (ONE, {"k": ""}, "axis 1: joint 'k' is not known; give one of j"),
    "joint named twice": (ONE, {"j": "", "j ": ""}, "axis 2: joint 'j ' is not known"),
    "joint missing": (ONE, {"": ""}, "axis 1: joint = '' is not a text"),
    "moves nothing": (mjcf(body("a", HINGE + ' range="-1 1"', 0.0)), {"j": ""}, "axis 1: joint 'j' moves nothing"),
    "no limits": (mjcf(body("a", HINGE, 1.0)), {"j": ""}, "'j' moves without limit; give low and high, or input"),
    "no limits on a slide": (
        mjcf(body("a", 'name="j" type="slide"', 1.0)),
        {"j": LINEAR},
        "'j' moves without limit; give low and high",
    ),
    "sine of a slide": (
        mjcf(body("a", 'name="j" type="slide" range="0 1"', 1.0)),
        {"j": LINEAR + 'input = "sin_cos"'},
        "input = 'sin_cos'; this core takes positions alone of a linear axis",
    ),
    "beyond the limits": (ONE, {"j": "low = -90"}, "low .. high = -90 .. 1 is beyond the limits of 'j', -1 .. 1 rad"),
    "length is no number": (ONE.replace("0.1 0 0", "nan 0 0"), {"j": ""}, '<inertial> pos="nan 0 0" is not a number'),
    "axis is no number": (ONE.replace("0 1 0", "nan 1 0"), {"j": ""}, '<joint> axis="nan 1 0" is not a number'),
    "counts of hundreds of digits": (ONE, {"j": f"counts_per_turn = 1{'0' * 400}"}, "counts_per_turn = 1000"),
    "negative mass": (ONE.replace('mass="1.0"', 'mass="-1"'), {"j": ""}, "body 'a' has mass -1 kg"),
    "unit clash": (ONE, {"j": LINEAR}, "counts_per_turn is missing; the axis moves in rad, counts_per_m is of"),
    "not XML": ("<mujoco", {"j": ""}, "not a URDF or MJCF: no XML"),
    "another XML": ("<svg/>", {"j": ""}, "begins with <svg>, not with <robot> of a URDF or <mujoco> of an MJCF"),
    "mass from a mesh": (
        mjcf('<body name="a"><joint name="j"/><geom type="mesh" mesh="m"/></body>',
             '<asset><mesh name="m" file="m.stl"/></asset>'),
        {"j": ""},
        "body 'a' has its mass from a mesh",
    ),
    "loops open": (
        mjcf(LOOP + body("b", 'name="k" axis="0 1 0"', 1.0, pos="1 0 0", inside='<site name="t" pos="0.3 0 0"/>'),
             '<equality><connect site1="s" site2="t"/></equality>'),
        {"j": ""},
        "the loops do not close at the reference pose: ",
    ),
    "loops leave joints free": (
        mjcf(body("a", HINGE + ' range="-1 1"', 1.0, inside=body("b", 'name="k" axis="0 1 0"', 1.0, pos="0.3 0 0",
             inside=body("c", 'name="l" axis="0 1 0"', 1.0, pos="0 0 0.3",
             inside=body("d", 'name="m" axis="0 1 0"', 1.0, pos="0.3 0 0")))),
             '<equality><connect body1="d" body2="world" anchor="0.1 0 0"/></equality>'),
        {"j": ""},
        "joints l, m can move while the axes stand: the loops leave 1 degrees",
    ),
    "loops hold an axis": (
        mjcf(LOOP, '<equality><weld body1="a" body2="world"/></equality>'), {"j": ""}, "the loops hold axis 1 fast"
    ),
    "floating": (
        mjcf(LOOP + '<body name="ball"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'),
        {"j": ""},
        "body 'ball' floats",
    ),
    "swinging": (
        mjcf(body("a", HINGE + ' range="-1 1"', 1.0, inside=body("b", 'type="ball"', 1.0, "0 0 0.1", "0.3 0 0"))),
        {"j": ""},
        "body 'b' swings on a ball joint: no loop ties it",
    ),
    "axes tied to one another": (
        mjcf(body("a", HINGE + ' range="-1 1"', 1.0, "0.1 0 0") + body("b", 'name="k" range="-1 1"', 1.0, "0.1 0 0"),
             '<equality><joint joint1="k" joint2="j" polycoef="0.1 -1 0 0 0"/></equality>'),
        {"j": "", "k": ""},
        "a loop or mimic ties 'k' and 'j', and all of them are axes; leave one out",
    ),
    "range that ends before it begins": (
        mjcf(body("a", HINGE + ' range="1 -1"', 1.0, "0.1 0 0")),
        {"j": "low = -1\nhigh = 1"},
        "joint 'j': its range 1 .. -1 ends before it begins",
    ),
    "no gravity": (
        mjcf(body("a", HINGE + ' range="-1 1"', 1.0, "0.1 0 0"), '<option gravity="0 0 0"/>'),
        {"j": ""},
        "gravity is zero: nothing is to be held; give m/s^2 here, or in the file's <option>",
    ),
    "axis that bears nothing": (
        mjcf(body("a", 'name="j" axis="0 0 1" range="-1 1"', 1.0, "0.1 0 0")),
        {"j": ""},
        "no axis bears a load at any of 3500 poses: nothing is to be held",
    ),
}  # fmt: skip


def refused(folder, words, capsys):
    """`gravcomp train` says one line, ends in 2 and writes nothing."""
    assert main(["train", "--robot", str(folder), "--out", str(folder / "out")]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert words in complaint
    assert not (folder / "out").exists()
    assert not (Path.cwd() / "MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize("case", BAD)
def test_bad_robot_is_refused_in_one_line(tmp_path, case, capsys):
    text, joints, words = BAD[case]
    refused(write_mechanism(tmp_path, text, joints), words, capsys)


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("gravity = [0, 0]", "[model] gravity = [0, 0] is not three numbers"),
        ("gravity = [0, 0, 0]", "[model] gravity is zero"),
        ('payload_body = "c"', "[model] payload_body = 'c' is not known; give one of a"),
        ("[model.held]\nk = 1", "[model.held]: joint 'k' is not known"),
        ("[model.held]\nj = 1", "[model.held]: joint 'j' is an axis"),
        ('[workspace]\nkind = "ball"', '[workspace] kind = \'ball\'; give "box" or "poses"'),
        ('[workspace]\nkind = "poses"\nfile = "none.csv"', "none.csv: not found"),
        ('[workspace]\nkind = "box"\nfile = "none.csv"', "[workspace]: file is not known; give kind"),
        ('payload = "a"', "[model]: payload is not known; give file, gravity, held, kind, payload_body"),
    ],
)
def test_bad_key_of_the_model_is_refused_in_one_line(tmp_path, model, words, capsys):
    refused(write_mechanism(tmp_path, ONE, {"j": ""}, model=model), words, capsys)


def test_missing_robot_file_is_refused_in_one_line(tmp_path, capsys):
    folder = write_mechanism(tmp_path, ONE, {"j": ""})
    (folder / "robot.xml").unlink()
    refused(folder, "robot.xml: not found; put the URDF or MJCF there", capsys)


def test_content_of_the_robot_file_belongs_to_what_a_network_is_trained_on(tmp_path):
    parts = {"robot.xml": ONE.replace("<worldbody>", '<include file="option.xml"/><worldbody>')}
    parts["option.xml"] = '<mujoco><option gravity="0 0 -9.8"/></mujoco>'
    folder = write_mechanism(tmp_path, parts["robot.xml"], {"j": ""})
    (folder / "option.xml").write_text(parts["option.xml"])
    before = load_machine(folder).trained_on()
    assert set(load_machine(folder).files) == set(parts)
    for name, text in parts.items():
        (folder / name).write_text(text + "\n")
        changed = load_machine(folder).trained_on()
        assert [key for key in before if before[key] != changed[key]] == [f"{name} sha256"]
        (folder / name).write_text(text)


def test_workspace_of_poses_is_its_rows(tmp_path):
    rows = "q1_rad,q2_rad\n0.1,0.2\n0.3,-0.4\n-0.5,0.6\n"
    folder = write_mechanism(tmp_path, ARM, TWO, model='[workspace]\nkind = "poses"\nfile = "poses.csv"')
    (folder / "poses.csv").write_text(rows)
    machine = load_machine(folder)
    drawn = machine.robot.workspace(3, 1)
    assert sorted(map(tuple, drawn.tolist())) == [(-0.5, 0.6), (0.1, 0.2), (0.3, -0.4)]
    assert "poses.csv" in machine.files


# RMS error in percent of the RMS effort, over poses that training has not seen, that a shipped network keeps.
REACHED = {"slide": 0.01, "arm2": 0.1, "fivebar": 0.2, "so101": 0.2, "panda": 1.0}


@pytest.mark.parametrize("name", REACHED)
def test_shipped_network_holds_its_machine_and_fits_the_core(name, tmp_path):
    folder = WEIGHTS / name
    machine, known = load_machine(folder), json.loads((folder / "provenance.json").read_text())
    unseen = workspace_set(N_TEST_POSES, machine.robot, known["data"]["test_seed"])
    network = load_network(folder)
    error = network.forces(unseen.q) - unseen.f
    percent = 100 * float(np.sqrt(np.mean(error**2) / np.mean(unseen.f**2)))
    print(f"MEASURED {name}: {percent:.3f} % RMS with {network.n_hidden} neurons")
    assert percent <= REACHED[name]
    assert percent == pytest.approx(known["metrics"]["test_rms_percent"], rel=1e-6)
    assert main(["rom", "--weights", str(folder), "--out", str(tmp_path)]) == 0
    fixed = quantise(network, machine.drive)
    counts = machine.drive.counts(unseen.q)
    exact = network.forces(machine.drive.positions(counts))
    error_mn = core(counts, fixed).force_mn - 1000 * exact
    assert np.sqrt(np.mean(error_mn**2)) <= np.hypot(1000 * MAX_SHARE * float(network.f_scale.max()), WHOLE_MN)
