"""The virtual prototype as an experiment: without effects it is the statics, with one it is off by that effect."""

import csv
import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from gravcomp.cli import main
from gravcomp.errors import InputError
from gravcomp.prototype.experiment import hold, log_csv, measure
from gravcomp.prototype.imperfections import EFFECTS, LISTED, UNLISTED
from gravcomp.prototype.plant import Plant
from gravcomp.prototype.travel import turning_rates
from gravcomp.robot.spheiro.kinematics import (
    PoseError,
    direct_kinematics,
    inverse_kinematics,
    jacobian,
    passive_jacobian,
)
from gravcomp.robot.spheiro.statics import holding_forces_at
from gravcomp.robot.spheiro.workspace import sample_workspace
from gravcomp_lab.paper.field import hold_field
from machines import MACHINE, SHIPPED, P

MEASURE = ["measure", "--robot", str(SHIPPED)]
MOTION_SEED = 91  # all axes move
VOCABULARY = {
    *("coulomb_friction", "viscous_friction", "stribeck_friction", "passive_joint_friction", "load_dependent_friction"),
    *("backlash", "cogging", "payload", "base_tilt", "thrust_constant", "encoder_offset", "current_offset"),
    *("cable_spring", "link_compliance", "thermal_drift", "inertia", "presliding_hysteresis", "body_moment"),
    *("universal_joint_friction", "platform_hose", "offset_step", "directional_load_friction"),
}


@pytest.fixture(scope="module")
def plain():
    return measure(MACHINE, [], 30, MOTION_SEED, mode="motion")


def residual_n(log):
    return log.effort - holding_forces_at(log.q, P)


def moved(name, **params):
    return measure(MACHINE, [EFFECTS[name](**params)], 30, MOTION_SEED, mode="motion")


def statics(q, shift=0.0):
    return holding_forces_at(q + shift, P)


def moment_to_forces(log, moment):
    """Motor forces that balance a moment on the platform: J^-T moment."""
    j = jacobian(direct_kinematics(log.q, P), P)
    return -np.linalg.solve(np.swapaxes(j, -1, -2), moment[..., None])[..., 0]


def payload(log, m, arm):
    lever = direct_kinematics(log.q, P) @ np.array(arm)
    return moment_to_forces(log, np.cross(lever, m * P.gravity_mps2))


def tilted(log, degrees):
    turn = Rotation.from_rotvec(degrees, degrees=True)
    p = type(P)(**{**vars(P), "gravity_direction": turn.apply(P.gravity_direction)})
    return holding_forces_at(log.q, p) - statics(log.q)


def passive(log, levels):
    j = passive_jacobian(direct_kinematics(log.q, P), P)
    v = np.einsum("...ij,...j->...i", j, log.v)
    return np.einsum("...ij,...i->...j", j, np.array(levels) * np.sign(v))


def turned(log, moment):
    """Motor forces of moments (angles, rates) in the hinges of the universal joints, inner ones first."""
    robot = MACHINE.robot
    j = robot.universal_jacobian(log.q)
    own = moment(robot.universal_angles(log.q), np.einsum("nij,nj->ni", j, log.v))
    return np.einsum("nij,ni->nj", j, own)


def stribeck(v):
    return (1.0 + 2.0 * np.exp(-((v / 0.004) ** 2))) * np.sign(v)


def test_effects_of_the_vocabulary_are_all_there_and_at_least_four_beyond():
    assert set(LISTED) == VOCABULARY
    assert len(UNLISTED) >= 4


@pytest.mark.parametrize(("mode", "n_points"), [("static", 60), ("motion", 240)])
def test_without_effects_the_measured_effort_is_the_statics(mode, n_points):
    log = measure(MACHINE, [], n_points, seed=1, mode=mode)
    rms_n = np.sqrt(np.mean(residual_n(log) ** 2))
    print(f"{mode}: effort without noise is off by {1e3 * rms_n:.1f} mN RMS")
    assert rms_n < 0.025
    noise_n = MACHINE.drive.effort_per_ampere * log.current_a - log.effort
    assert noise_n.std() == pytest.approx(0.1, rel=0.25)


# name, parameters, effect in N by the equation of the design, tolerance in N
@pytest.mark.parametrize(
    ("name", "params", "expected", "tolerance_n"),
    [
        ("coulomb_friction", {"fc": 2.0, "fc1": 1.0}, lambda g: [1.0, 2.0, 2.0] * np.sign(g.v), 0.1),
        ("coulomb_friction", {"fc": 2.0, "skew": 0.5}, lambda g: 2.0 * np.sign(g.v) + 0.5, 0.1),
        ("viscous_friction", {"b": 300.0}, lambda g: 300.0 * g.v, 0.1),
        ("stribeck_friction", {"fc": 1.0, "fs": 3.0, "vs": 0.004}, lambda g: stribeck(g.v), 0.15),
        ("passive_joint_friction", {"fc_b": 1.5, "fc_phi": 0.2}, lambda g: passive(g, [1.5] * 3 + [0.2] * 3), 0.1),
        ("universal_joint_friction", {"fc": 0.3}, lambda g: turned(g, lambda angles, rate: 0.3 * np.sign(rate)), 0.1),
        ("platform_hose", {"k": 1.0}, lambda g: turned(g, lambda angles, rate: angles * np.repeat([0.0, 1.0], 3)), 0.1),
        ("load_dependent_friction", {"mu": 0.05}, lambda g: 0.05 * np.abs(statics(g.q)) * np.sign(g.v), 0.1),
        (
            "directional_load_friction",
            {"mu_motor": 0.05, "mu_load": 0.02},
            lambda g: np.where(statics(g.q) * g.v > 0, 0.05, 0.02) * np.abs(statics(g.q)) * np.sign(g.v),
            0.15,
        ),
        ("backlash", {"gap": 0.001}, lambda g: statics(g.q, -0.0005 * np.sign(g.v)) - statics(g.q), 0.06),
        (
            "cogging",
            {"a": 2.0, "phase": 0.3, "a_second": 0.5, "phase_second": 1.0, "pitch": 0.008},
            lambda g: 2 * np.sin(250 * np.pi * g.q + 0.3) + 0.5 * np.sin(500 * np.pi * g.q + 1.0),
            0.08,
        ),
        ("payload", {"m": 1.5, "x": 0.1, "y": -0.05, "z": 0.02}, lambda g: payload(g, 1.5, [0.1, -0.05, 0.02]), 0.1),
        ("base_tilt", {"x_deg": 1.0, "y_deg": -0.5, "z_deg": 0.2}, lambda g: tilted(g, [1.0, -0.5, 0.2]), 0.1),
        ("thrust_constant", {"gain": 0.04, "gain2": -0.02}, lambda g: [0.04, -0.02, 0.04] * statics(g.q), 0.1),
        ("encoder_offset", {"offset": 0.002}, lambda g: statics(g.q, 0.002) - statics(g.q), 0.1),
        ("current_offset", {"o": 1.5, "o3": -1.0}, lambda g: [1.5, 1.5, -1.0] + 0 * g.q, 0.1),
        ("cable_spring", {"k": 40.0, "q0": 0.03}, lambda g: 40.0 * (g.q - 0.03), 0.1),
        ("link_compliance", {"c": -2e-5}, lambda g: statics(g.q, -2e-5 * g.effort) - statics(g.q), 0.05),
        (
            "thermal_drift",
            {"gain": 0.2, "tau_s": 5.0},
            lambda g: 0.2 * (1 - np.exp(-g.t_s / 5.0))[:, None] * statics(g.q),
            0.12,
        ),
        (
            "thermal_drift",
            {"gain": 0.0, "gain_per_k": 0.1},
            lambda g: 0.1 * (g.temperature_c - 22.0)[:, None] * statics(g.q),
            0.1,
        ),
        ("presliding_hysteresis", {"fc": 1.5, "travel": 0.0001}, lambda g: 1.5 * np.sign(g.v), 0.1),
        ("soft_stop", {"k": 2000.0, "q0": -0.02}, lambda g: 2000.0 * np.maximum(g.q + 0.02, 0) ** 2, 0.15),
        (
            "friction_bump",
            {"fc": 3.0, "q0": 0.0, "width": 0.05},
            lambda g: 3.0 * np.exp(-((g.q / 0.05) ** 2)) * np.sign(g.v),
            0.1,
        ),
        ("current_crosstalk", {"c": 0.05}, lambda g: 0.05 * np.roll(statics(g.q), -1, axis=1), 0.1),
        ("magnetic_saturation", {"f_sat": 300.0}, lambda g: statics(g.q) ** 3 / 9e4, 0.12),
        (
            "periodic_disturbance",
            {"a": 1.0, "period_s": 4.0},
            lambda g: np.sin(np.pi * g.t_s / 2)[:, None] + 0 * g.q,
            0.12,
        ),
        ("offset_step", {"a": 1.0, "t0_s": 3.0}, lambda g: (g.t_s > 3.0)[:, None] + 0 * g.q, 0.1),
    ],
)
def test_effect_shows_with_the_size_and_sign_asked_for(plain, name, params, expected, tolerance_n):
    log = moved(name, **params)
    effect = expected(log)
    shown = residual_n(log) - residual_n(plain)
    is_moving = np.abs(log.v) > 1e-3
    is_clear = np.all([np.roll(is_moving, k, axis=0) for k in range(4)], axis=0)  # well after a stop or reversal
    assert is_clear.sum(axis=0).min() >= 10
    assert np.abs(effect[is_clear]).max() > 2 * tolerance_n
    np.testing.assert_allclose(shown[is_clear], effect[is_clear], atol=tolerance_n)


def test_effects_add_up(plain):
    both = measure(
        MACHINE,
        [EFFECTS["coulomb_friction"](fc=1.0), EFFECTS["load_dependent_friction"](mu=0.03)],
        30,
        MOTION_SEED,
        mode="motion",
    )
    expected = (1.0 + 0.03 * np.abs(statics(both.q))) * np.sign(both.v)
    is_moving = np.abs(both.v) > 2e-3
    np.testing.assert_allclose((residual_n(both) - residual_n(plain))[is_moving], expected[is_moving], atol=0.1)


# Holds begin on their way after long travel: history and equilibrium have to be right from the first step.
@pytest.mark.parametrize(
    ("name", "params", "expected"),
    [
        ("payload", {"m": 2.0, "x": 0.1, "y": 0.0, "z": 0.0}, lambda g: payload(g, 2.0, [0.1, 0.0, 0.0])),
        ("cable_spring", {"k": 100.0, "q0": 0.0}, lambda g: 100.0 * g.q),
        ("backlash", {"gap": 0.004}, lambda g: statics(g.q, -0.002 * np.sign(g.v)) - statics(g.q)),
        ("presliding_hysteresis", {"fc": 2.0, "travel": 0.004}, lambda g: 2.0 * np.sign(g.v)),
    ],
)
def test_effect_shows_in_holds(name, params, expected):
    log = measure(MACHINE, [EFFECTS[name](**params)], 12, 1, mode="static")
    is_clear = np.abs(log.v).min(axis=1) > 3e-5
    np.testing.assert_allclose(residual_n(log)[is_clear], expected(log)[is_clear], atol=0.1)


def test_inertia_shows_in_fast_motion():
    light, heavy = (measure(MACHINE, e, 60, 1, mode="motion", speed=8.0) for e in ([], [EFFECTS["inertia"](m=20.0)]))
    acceleration = np.gradient(light.v, light.t_s, axis=0)
    more = (heavy.effort - light.effort)[2:-2]
    slope = np.sum(more * acceleration[2:-2]) / np.sum(acceleration[2:-2] ** 2)
    assert slope == pytest.approx(20.0, rel=0.1)


@pytest.mark.parametrize("name", ["universal_joint_friction", "platform_hose"])
def test_effect_inside_the_mechanism_grows_with_its_size(plain, name):
    (parameter,) = EFFECTS[name].ranges
    shown = (residual_n(moved(name, **{parameter: size})) - residual_n(plain) for size in (0.2, 0.4))
    small, large = (np.sqrt(np.mean(effect[5:-5] ** 2)) for effect in shown)
    assert small > 0.05
    assert large == pytest.approx(2 * small, rel=0.1)


def test_held_forces_lag_in_the_direction_of_approach_within_the_friction():
    log = measure(MACHINE, [EFFECTS["coulomb_friction"](fc=2.0)], 60, seed=2, mode="static")
    is_moving = np.abs(log.v) > 3e-5
    lag = (residual_n(log) * np.sign(log.v) / 2.0)[is_moving]
    print(f"lag of holds in parts of the friction: mean {lag.mean():.3f}, {lag.min():.3f} to {lag.max():.3f}")
    assert 0.9 < lag.mean() < 1.0
    assert lag.min() > 0.8
    assert lag.max() < 1.03


def test_same_seed_gives_the_same_file_and_another_seed_another():
    effects = [EFFECTS["cogging"](), EFFECTS["backlash"]()]
    first, again, other = (log_csv(measure(MACHINE, effects, 16, seed), MACHINE) for seed in (1, 1, 2))
    assert first == again
    assert first != other


def test_csv_has_the_columns_quantised_and_no_word_of_the_effect(tmp_path):
    path = tmp_path / "log.csv"
    arguments = [*MEASURE, "--effect", "payload:m=1", "--effect", "random_unlisted", "--points", "16", "--seed", "5"]
    assert main([*arguments, "--out", str(path), "--temperature"]) == 0
    text = path.read_text()
    assert "#" not in text
    rows = list(csv.DictReader(text.splitlines()))
    names = [
        "t_s",
        *(f"{x}{i}_{unit}" for x, unit in (("q", "m"), ("v", "mps"), ("i", "a")) for i in (1, 2, 3)),
        "temp_c",
    ]
    assert list(rows[0]) == names
    assert len(rows) == 16
    table = np.array([[float(value) for value in row.values()] for row in rows])
    assert (np.diff(table[:, 0]) > 0).all()
    counts = table[:, 1:4] / MACHINE.drive.unit_per_count
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-4)
    assert np.abs(MACHINE.drive.effort_per_ampere * table[:, 7:10] - holding_forces_at(table[:, 1:4], P)).max() > 0.5


def test_sealed_answer_names_what_was_put_in(tmp_path):
    main(
        [
            *MEASURE,
            "--effect",
            "payload:m=1,x=0.1",
            "--effect",
            "soft_stop",
            "--points",
            "8",
            "--seed",
            "4",
            "--out",
            f"{tmp_path}/a.csv",
        ]
    )
    answer = json.loads((tmp_path / "a.sealed.json").read_text())
    assert [(e["name"], e["on_list"]) for e in answer["effects"]] == [("payload", True), ("soft_stop", False)]
    assert answer["effects"][0]["params"]["m"] == 1.0
    assert len(answer["effects"][1]["params"]["k"]) == 3
    assert (answer["seed"], answer["noise"], answer["mode"]) == (4, [0.1] * 3, "both")
    assert min(answer["effect_rms"]) > 0.3


def test_random_effects_follow_the_seed_and_differ_among_seeds(tmp_path):
    drawn = []
    for seed in (1, 1, 2, 3, 4):
        path = tmp_path / "log.csv"
        main([*MEASURE, "--effect", "random", "--points", "8", "--seed", str(seed), "--out", str(path)])
        drawn.append(json.loads(path.with_suffix(".sealed.json").read_text())["effects"])
    assert drawn[0] == drawn[1]
    assert len({json.dumps(d) for d in drawn}) == 4
    assert all(d[0]["on_list"] for d in drawn)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--effect", "frction"], "--effect frction: not known"),
        (["--effect", "payload:mass=1"], "unknown parameter mass; it has m, x, y, z"),
        (["--effect", "payload:m"], "'m' is not PARAM=NUMBER"),
        (["--effect", "payload:m=one"], "'m=one' is not PARAM=NUMBER"),
        (["--effect", "payload:m=nan"], "m = nan is not a finite number"),
        (["--effect", "viscous_friction:b=1e7"], "the PID can't follow this motion"),
        (["--effect", "link_compliance:c=1e-3"], "the PID can't follow this motion"),
        (["--effect", "encoder_offset:offset=0.4"], "singular face"),
        (["--points", "3"], "at least 8 points"),
        (["--noise", "-1"], "must not be negative"),
        (["--speed", "nan"], "must be in 0..100"),
        (["--robot", "absent"], "absent: no robot.toml"),
    ],
)
def test_wrong_request_is_refused_in_one_line_and_nothing_is_written(tmp_path, capsys, arguments, said):
    path = tmp_path / "log.csv"
    assert main([*MEASURE, "--points", "8", "--out", str(path), *arguments]) == 2
    message = capsys.readouterr().err
    assert said in message
    assert len(message.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def held(effects, poses):
    sides = np.random.default_rng(3).standard_normal((len(poses), 3))
    targets, rates = inverse_kinematics(poses, P), turning_rates(poses, sides, P)
    return hold(Plant(MACHINE, effects), targets, rates, tqdm(disable=True))


def test_held_poses_are_read_where_asked_and_carry_the_friction():
    poses = sample_workspace(12, P, seed=3, torsion_deg=15.0)
    samples = held([EFFECTS["coulomb_friction"](fc=2.0)], poses)
    q = np.array([sample.q for sample in samples])
    np.testing.assert_allclose(q, inverse_kinematics(poses, P), atol=2e-5)
    off = np.abs(np.array([sample.effort for sample in samples]) - holding_forces_at(q, P))
    assert 1.0 < off.mean() < 2.0
    assert off.max() < 2.1
    with pytest.raises(PoseError, match=r"^pose 0 \(and 11 more\) is not a rotation"):
        held([], 2.0 * poses)


def test_field_effects_make_the_analytic_model_err_as_in_the_paper():
    data = hold_field(MACHINE, sample_workspace(60, P, seed=7, torsion_deg=0.0), "random", seed=7)
    percent = 100 * np.linalg.norm(data.force - data.nominal, axis=1) / np.linalg.norm(data.force, axis=1)
    print(f"analytic model on the field, torsion 0: {percent.mean():.1f} % on average (paper: 3.8 %)")
    assert percent.mean() == pytest.approx(3.8, abs=0.4)


def test_unknown_mode_is_refused():
    with pytest.raises(InputError, match="mode 'dynamic'"):
        measure(MACHINE, [], 8, 0, mode="dynamic")
