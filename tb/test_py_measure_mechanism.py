"""Virtual prototypes of robots of a file: without imperfections they are the statics, with one they are off by it."""

import tomllib

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gravcomp.cli import main
from gravcomp.errors import optional
from gravcomp.prototype.experiment import measure
from gravcomp.prototype.imperfections import EFFECTS
from gravcomp.prototype.mechanism_engine import MechanismEngine
from gravcomp.prototype.plant import Plant, engine_of
from gravcomp.prototype.sizes import sizes_of
from gravcomp.robot.machine import load_machine
from mechanisms import SHIPPED_MECHANISMS, WEIGHTS, body, mechanism, mjcf

ARM, FIVEBAR, UR5, SLIDE = (load_machine(WEIGHTS / name) for name in ("arm2", "fivebar", "ur5", "slide"))


def held(machine, *effects, n_points=8):
    return measure(machine, effects, n_points, 3, mode="static", noise=0.0)


def beyond(machine, log):
    return log.effort - machine.robot.forces(log.q)


@pytest.mark.parametrize("machine", [SLIDE, ARM, FIVEBAR, UR5], ids=lambda m: m.name)
def test_without_imperfections_holds_and_motion_are_the_statics(machine):
    size = 0.1 * Plant(machine).sizes.effort  # the noise that measuring puts on top
    for mode, n_points, most in (("static", 12, 0.4), ("motion", 60, 1.6)):  # inertia is in motion too
        log = measure(machine, [], n_points, 1, mode=mode, noise=0.0)
        rms = np.sqrt(np.mean(beyond(machine, log) ** 2, axis=0)) / size
        print(f"{machine.name}, {mode}: off by {rms.round(2)} of the usual noise")
        assert (rms < most).all()


def statics(machine, log, shift=0.0):
    return machine.robot.forces(log.q + shift) - machine.robot.forces(log.q)


def tilted(machine, log, degrees):
    down = Rotation.from_rotvec(degrees, degrees=True).apply(machine.robot.gravity_direction)
    return machine.robot.with_gravity(down).forces(log.q) - machine.robot.forces(log.q)


def arm_payload(log, m, x, z):
    """A mass m at (x, 0, z) of the tool, 0.3 m behind the elbow, 0.4 m behind the shoulder; g = 9.81 m/s^2."""
    q1, q2 = log.q.T
    elbow = (0.3 + x) * np.cos(q1 + q2) - z * np.sin(q1 + q2)
    return 9.81 * m * np.stack([0.4 * np.cos(q1) + elbow, elbow], axis=1)


CASES = {
    "coulomb_friction": ({"fc": 0.4, "fc1": 0.8}, lambda g: [0.8, 0.4] * np.sign(g.v)),
    "payload": ({"m": 0.5, "x": 0.1, "y": 0.0, "z": 0.05}, lambda g: arm_payload(g, 0.5, 0.1, 0.05)),
    "base_tilt": ({"x_deg": 0.5, "y_deg": 3.0, "z_deg": 0.0}, lambda g: tilted(ARM, g, [0.5, 3.0, 0.0])),
    "encoder_offset": ({"offset": 0.02, "offset2": -0.03}, lambda g: statics(ARM, g, [0.02, -0.03])),
    "link_compliance": ({"c": -6e-4}, lambda g: statics(ARM, g, -6e-4 * g.effort)),
    "backlash": ({"gap": 0.02}, lambda g: statics(ARM, g, -0.01 * np.sign(g.v))),
    "thrust_constant": ({"gain": 0.05}, lambda g: 0.05 * ARM.robot.forces(g.q)),
    "cable_spring": ({"k": 0.5, "q0": 0.3}, lambda g: 0.5 * (g.q - 0.3)),
}


@pytest.mark.parametrize("name", CASES)
def test_imperfection_of_an_arm_shows_with_its_size_and_sign(name):
    parameters, expected = CASES[name]
    sizes = Plant(ARM).sizes
    log = held(ARM, EFFECTS[name](sizes, **parameters))
    effect = expected(log)
    assert np.abs(effect).max() > 0.12
    np.testing.assert_allclose(beyond(ARM, log), effect, atol=0.05)


@pytest.mark.parametrize("name", SHIPPED_MECHANISMS)
def test_every_imperfection_that_a_shipped_machine_can_have_is_in_its_engine(name):
    """MuJoCo sets its constants up again and moves the machine one step, or the effect is said to be of others."""
    machine = load_machine(WEIGHTS / name)
    q = machine.robot.workspace(1, 4)[0]
    for effect in EFFECTS:
        engine = engine_of(machine)
        sizes = sizes_of(machine, engine)
        if EFFECTS[effect].is_of(engine, sizes):
            plant = Plant(machine, [EFFECTS[effect](sizes)])
            plant.place(q, np.zeros(machine.n_axes), 0.0)
            plant.step(q)
            assert np.isfinite(plant.effort()).all(), effect


@pytest.mark.slow
def test_payload_and_friction_of_a_slide_are_diagnosed_and_written_back(tmp_path):
    """Slides feel no moment of it, whatever that is: it stays of no size. The file has the mass and the friction."""
    log, out, file = tmp_path / "log.csv", tmp_path / "out", tmp_path / "corrected.xml"
    effects = ["--effect", "payload:m=1.2", "--effect", "viscous_friction:b=90", "--effect", "coulomb_friction:fc=2.5"]
    slide = ["--robot", str(WEIGHTS / "slide")]
    assert main(["measure", *slide, *effects, "--points", "300", "--seed", "5", "--out", str(log)]) == 0
    assert main(["diagnose", str(log), *slide, "--out", str(out)]) == 0
    found = {effect["name"]: effect["params"] for effect in tomllib.loads((out / "model.toml").read_text())["effects"]}
    assert found["payload"]["mass"] == pytest.approx(1.2, rel=0.01)
    assert all(abs(found["payload"][f"moment_{axis}"]) < 1e-3 for axis in "xyz")
    assert main(["correct", str(out / "model.toml"), "--out", str(file)]) == 0
    model = optional("mujoco", "mujoco", "the test").MjModel.from_xml_path(str(file))
    assert model.body("carriage").mass[0] == pytest.approx(14 + 1.2, rel=0.002)
    # At the speed of the log: what both frictions are together is known better than either.
    v = 0.004
    friction_n = model.dof_frictionloss[0] + model.dof_damping[0] * v
    assert friction_n == pytest.approx(2.5 + 90 * v, rel=0.1)


def test_payload_on_a_gantry_of_three_slides_bears_on_the_upright_one(tmp_path):
    """Bodies whose frames all stand alike are MuJoCo's simple ones: m g more on z, nothing on x and y."""
    slide = 'name="{0}" type="slide" axis="{1}" range="-0.4 0.4"'.format
    tool = body("tool", slide("z", "0 0 1"), 3.0)
    world = body("bridge", slide("x", "1 0 0"), 9.0, inside=body("cart", slide("y", "0 1 0"), 5.0, inside=tool))
    machine = mechanism(tmp_path, mjcf(world), dict.fromkeys("xyz", "counts_per_m = 1000000"))
    sizes = Plant(machine).sizes
    for effect, more_n in (
        (EFFECTS["payload"](sizes, m=0.8, x=0.05, y=-0.02, z=0.1), 9.81 * 0.8),
        (EFFECTS["body_moment"](sizes, x=0.3, y=0.2, z=0.1), 0.0),
    ):
        log = held(machine, effect)
        np.testing.assert_allclose(beyond(machine, log), np.tile([0.0, 0.0, more_n], (8, 1)), atol=0.05)


def test_moment_of_a_named_body_is_that_of_its_regressor():
    sizes = Plant(UR5).sizes
    log = held(UR5, EFFECTS["body_moment"](sizes, body="forearm_link", x=0.3, y=-0.2, z=0.1))
    body_number = UR5.robot.body_names.index("forearm_link")
    expected = UR5.robot.moment_regressors(log.q)[:, :, body_number] @ [0.3, -0.2, 0.1]
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(beyond(UR5, log), expected, atol=0.05)


def test_friction_in_passive_joints_of_a_loop_comes_through_the_loop():
    log = held(FIVEBAR, EFFECTS["passive_joint_friction"](Plant(FIVEBAR).sizes, fc_phi=0.1))
    j = FIVEBAR.robot.passive_jacobian(log.q)
    expected = np.einsum("npk,np->nk", j, 0.1 * np.sign(np.einsum("npk,nk->np", j, log.v)))
    assert np.abs(expected).max() > 0.05
    np.testing.assert_allclose(beyond(FIVEBAR, log), expected, atol=0.02)


def test_joint_that_is_no_axis_stands_where_robot_toml_holds_it(tmp_path):
    """A 1 kg mass 0.5 m out on a held hinge that points up at 0.4 rad: g (0.3 cos q + 0.5 cos(q + 0.4)) on the axis."""
    world = body("upper", 'name="a" axis="0 -1 0" range="-1 1"', 1.0, "0.3 0 0",
                 inside=body("lower", 'name="held" axis="0 -1 0" range="-1 1"', 1.0, "0.5 0 0"))  # fmt: skip
    machine = mechanism(tmp_path, mjcf(world), {"a": ""}, model="[model.held]\nheld = 0.4")
    engine = engine_of(machine)
    assert isinstance(engine, MechanismEngine)
    for q in (-0.5, 0.2):
        engine.place(np.array([q]), np.zeros(1))
        expected = 9.81 * (0.3 * np.cos(q) + 0.5 * np.cos(q + 0.4))
        assert engine.equilibrium_efforts() == pytest.approx([expected], rel=1e-6)


def test_log_of_an_arm_has_columns_in_its_units_and_is_diagnosed_with_its_machine(tmp_path):
    arguments = ["measure", "--robot", str(WEIGHTS / "arm2"), "--points", "60", "--mode", "static", "--seed", "2"]
    log = tmp_path / "log.csv"
    assert main([*arguments, "--effect", "coulomb_friction:fc=0.5", "--out", str(log)]) == 0
    assert log.read_text().splitlines()[0] == "t_s,q1_rad,q2_rad,v1_radps,v2_radps,i1_a,i2_a"
    out = tmp_path / "out"
    assert main(["diagnose", str(log), "--robot", str(WEIGHTS / "arm2"), "--out", str(out)]) == 0
    assert 'name = "coulomb_friction"' in (out / "model.toml").read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--effect", "body_moment:body=nose"], "body 'nose' is not known"),
        (["--effect", "body_moment:x=far"], "'x=far' is not PARAM=NUMBER"),
        (["--effect", "passive_joint_friction"], "this machine has nothing for it to act on"),
        (["--effect", "universal_joint_friction"], "this machine has nothing for it to act on"),
        (["--effect", "viscous_friction:b=1e7"], "the PID can't follow this motion"),
        (["--effect", "body_moment:x=1e308"], "the PID can't follow this motion"),
        (["--effect", "payload:m=-1000"], "m = -1000 kg leaves"),
        (["--effect", "thermal_drift:tau_s=0"], "tau_s = 0.0 is not a finite number above 0"),
        (["--effect", "periodic_disturbance:period_s=0"], "period_s = 0.0 is not a finite number above 0"),
        (["--effect", "cogging:pitch=-0.1"], "pitch = -0.1 is not a finite number above 0"),
        (["--effect", "friction_bump:width2=0"], "is not a finite number above 0"),
        (["--effect", "coulomb_friction:fc=-1"], "fc = [-1. -1.] is not a finite number of 0 or more"),
        (["--effect", "backlash:gap=nan"], "gap = [nan nan] is not a finite number of 0 or more"),
        (["--effect", "current_offset:o=inf"], "o = [inf inf] is not a finite number; give one"),
        (["--effect", "thrust_constant:gain=1.7e308"], "currents beyond all numbers"),
        (["--effect", "payload:m=1,m=2"], "m is given twice"),
        (["--effect", "random:m=1"], "takes no parameters, 'm=1' is left over"),
    ],
)
def test_wrong_request_of_an_arm_is_refused_in_one_line(tmp_path, capsys, arguments, said):
    path = tmp_path / "log.csv"
    assert main(["measure", "--robot", str(WEIGHTS / "arm2"), "--points", "8", "--out", str(path), *arguments]) == 2
    message = capsys.readouterr().err
    assert said in message
    assert len(message.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_table_of_efforts_has_no_mechanics_to_measure_on(tmp_path, capsys):
    (tmp_path / "table.csv").write_text("q1_m,f1_n\n" + "".join(f"{k / 100},{k}\n" for k in range(60)))
    (tmp_path / "robot.toml").write_text(
        'name="t"\nclock_hz=40e6\n[network]\nactivation="gamma"\n[model]\nkind="table"\nfile="table.csv"\n'
        "[[axis]]\ncounts_per_m=1000\neffort_per_ampere=10.0\n"
    )
    assert main(["measure", "--robot", str(tmp_path), "--out", str(tmp_path / "log.csv")]) == 2
    assert "no mechanics to measure on" in capsys.readouterr().err
