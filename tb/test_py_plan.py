"""The plan: the next measurement tells rivals apart, within reach, and says what none can tell apart."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.plan.plan import ENOUGH, Reach, Rival, _contests, plan
from gravcomp.errors import InputError
from gravcomp.logs.joining import joined
from gravcomp.logs.measurement import Measurement
from gravcomp_lab.blind import next_motion
from machines import MACHINE
from measured_samples import REACH_M, sampled

N = 60
NOISE = np.array([0.05])


def arm_holds(speed: float = 0.02, n: int = N, seed: int = 1) -> Measurement:
    """Holds of a rotary axis, 8 Nm cos q, each approached at this speed from either side."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, (n, 1))
    v = speed * rng.choice([-1.0, 1.0], (n, 1))
    at = lambda x: 8.0 * np.cos(x)  # noqa: E731
    return Measurement("holds", 2.0 * np.arange(n), q, v, at(q), at(q), "Nm", ("rad",), force_at=at)


def rival(name: str, **parameters: float) -> Rival:
    return Rival((name,), ((name, {Parameter.parse(key): value for key, value in parameters.items()}),))


COULOMB, VISCOUS = rival("coulomb_friction", fc_1=0.2), rival("viscous_friction", b_1=10.0)
REACH = Reach(np.array([-1.0]), np.array([1.0]), np.array([0.1]))


def test_tangent_is_the_derivative_of_the_force():
    data = arm_holds()
    fc, vs, fs = (Parameter(stem, 0) for stem in ("fc", "vs", "fs"))
    stribeck = Rival((), (("stribeck_friction", {fc: 0.2, fs: 0.3, vs: 0.015}),))
    fall = np.exp(-((data.v / 0.015) ** 2))
    sign = np.sign(data.v)
    wanted = {fc: (1.0 - fall) * sign, fs: fall * sign, vs: 0.1 * fall * 2.0 * data.v**2 / 0.015**3 * sign}
    in_order = np.stack([wanted[name] for name in stribeck.effects[0][1]], axis=-1)
    np.testing.assert_allclose(stribeck.tangent(data), in_order, rtol=1e-5, atol=1e-8)


def test_evidence_is_what_the_rival_misses_on_both_together():
    """Against least squares over all rows at once, with the change between the two measurements as columns."""
    log, pool = arm_holds(), arm_holds(speed=0.005, seed=2)
    pool = replace(pool, v=np.where(np.arange(N)[:, None] % 3 == 0, 4.0 * pool.v, pool.v), run=np.ones(N, int))
    contest = next(c for c in _contests(log, pool, [COULOMB, VISCOUS], NOISE) if c.pair == (COULOMB, VISCOUS))
    rows = np.arange(0, N, 2)
    v, new = np.r_[log.v, pool.v[rows]][:, 0], np.r_[np.zeros(N), np.ones(len(rows))]
    columns, y = np.column_stack([v, new, new * np.sign(v)]), 0.2 * np.sign(v) - 10.0 * v
    left = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    alone = y[:N] - v[:N] * (v[:N] @ y[:N]) / (v[:N] @ v[:N])
    assert contest.of(rows) == pytest.approx((np.sum(left**2) - np.sum(alone**2)) / NOISE[0] ** 2, rel=1e-6)
    assert contest.of(rows) > 1.0


def test_another_speed_alone_is_no_evidence():
    """All new holds at one other speed: friction that changed in between would explain the same."""
    log, pool = arm_holds(), replace(arm_holds(speed=0.1, seed=2), run=np.ones(N, int))
    contest = next(c for c in _contests(log, pool, [COULOMB, VISCOUS], NOISE) if c.pair == (COULOMB, VISCOUS))
    assert contest.of(np.arange(N)) < 1.0


def test_holds_take_several_speeds_and_half_of_them_again():
    log = arm_holds()
    found = plan(log, [COULOMB, VISCOUS], NOISE, REACH)
    assert found.is_enough
    assert not found.is_motion
    assert len(found.rows.t_s) % 2 == 0
    of_log = np.isin(found.rows.q[:, 0], log.q[:, 0]) & np.isclose(np.abs(found.rows.v[:, 0]), 0.02)
    assert np.count_nonzero(of_log) >= len(found.rows.t_s) // 2
    assert len(np.unique(np.abs(found.rows.v).round(6))) >= 3


def test_plan_is_the_same_for_the_same_seed_and_no_longer_than_it_need_be():
    log, rivals = arm_holds(), [COULOMB, VISCOUS]
    first, again = (plan(log, rivals, NOISE, REACH) for _ in range(2))
    np.testing.assert_array_equal(first.rows.v, again.rows.v)
    noisy = plan(log, rivals, 20.0 * NOISE, REACH)
    assert len(noisy.rows.t_s) > len(first.rows.t_s)


def test_rows_stay_within_the_reach():
    reach = Reach(np.array([-0.5]), np.array([0.3]), np.array([0.03]))
    log = replace(arm_holds(), q=0.3 * arm_holds().q)
    found = plan(log, [COULOMB, VISCOUS], NOISE, reach)
    assert found.rows.q.min() >= -0.5
    assert found.rows.q.max() <= 0.3
    assert np.abs(found.rows.v).max() <= 0.03 + 1e-12


def test_poses_of_a_robot_are_those_of_its_workspace():
    rng = np.random.default_rng(4)
    q = rng.uniform(-REACH_M, REACH_M, (N, 3))
    log = sampled(2.0 * np.arange(N), q, 0.005 * rng.choice([-1.0, 1.0], (N, 3)))
    pair = [rival("coulomb_friction", fc_1=1.0, fc_2=1.0, fc_3=1.0),
            rival("viscous_friction", b_1=200.0, b_2=200.0, b_3=200.0)]  # fmt: skip
    found = plan(log, pair, np.full(3, 0.2), Reach.of(log))
    assert found.is_enough
    assert np.isfinite(MACHINE.robot.forces(found.rows.q)).all()  # raises PoseError outside


def test_motion_follows_a_motion_and_keeps_to_the_speed():
    t = 0.05 * np.arange(200)
    q = 0.4 * np.sin(0.8 * t)[:, None] + 0.6
    v, at = 0.32 * np.cos(0.8 * t)[:, None], lambda x: 8.0 * np.cos(x)
    log = Measurement("motion", t, q, v, at(q), at(q), "Nm", ("rad",), force_at=at)
    spring = Rival(("cable_spring",), (("cable_spring", {Parameter("k", 0): 0.4, Parameter("q0", 0): 0.0}),))
    reach = Reach(np.array([-1.5]), np.array([1.5]), np.array([0.5]))
    found = plan(log, [rival("thrust_constant", gain_1=0.05), spring], NOISE, reach)
    assert found.is_motion
    assert found.is_enough
    step = np.diff(found.rows.q[:, 0])
    assert np.abs(step).max() <= 1.05 * 0.5 * 0.05
    assert found.rows.q.min() >= -1.5
    assert found.rows.q.max() <= 1.5


def test_what_no_measurement_tells_apart_is_said():
    log = replace(arm_holds(), nominal=np.full((N, 1), 8.0), force_at=lambda x: np.full(x.shape, 8.0))
    found = plan(log, [rival("thrust_constant", gain_1=0.1), rival("current_offset", o_1=0.8)], NOISE, REACH)
    assert found.rows is None
    assert found.same == (("thrust_constant", "current_offset"),)


def test_logs_are_joined_run_by_run():
    first, then = arm_holds(), arm_holds(speed=0.1, n=10, seed=5)
    both = joined(first, then)
    assert (np.diff(both.t_s) > 0).all()
    np.testing.assert_array_equal(both.runs, np.r_[np.zeros(N), np.ones(10)])
    np.testing.assert_array_equal(both.v, np.r_[first.v, then.v])
    with pytest.raises(InputError, match="other axes, units or columns"):
        joined(first, replace(then, v=None))


def csv(data: Measurement, force: np.ndarray) -> str:
    rows = np.column_stack([data.t_s, data.q, data.v, force, data.nominal])
    lines = [",".join(f"{x:.9g}" for x in row) for row in rows]
    return "\n".join(["t_s,q1_rad,v1_radps,f1_nm,fm1_nm", *lines]) + "\n"


def viscous_machine(data: Measurement, seed: int) -> np.ndarray:
    noise = NOISE * np.random.default_rng(seed).standard_normal(data.shape)
    return data.nominal + 10.0 * data.v + noise


def test_from_the_first_log_to_one_name_on_the_command_line(tmp_path, capsys):
    log = arm_holds(n=120)
    (tmp_path / "log.csv").write_text(csv(log, viscous_machine(log, 1)))
    first, out = str(tmp_path / "log.csv"), str(tmp_path / "out")
    assert main(["diagnose", first, "--out", out]) == 0
    names = json.loads((tmp_path / "out" / "report.json").read_text())["alternatives"]
    assert any({"coulomb_friction", "viscous_friction"} <= {*own} for own in names)
    assert main(["plan", first, "--report", out, "--speed", "0.1"]) == 0
    said = capsys.readouterr().out
    assert "coulomb friction" in said
    assert f"expected evidence {ENOUGH:g}" not in said
    lines = (tmp_path / "out" / "plan.csv").read_text().splitlines()
    assert lines[0].startswith("# ")
    assert lines[1] == "hold,q1_rad,v1_radps"
    _, q, v = np.array([[float(x) for x in line.split(",")] for line in lines[2:]]).T[:, :, None]
    then = Measurement("next", 2.0 * np.arange(len(q)), q, v, q, 8.0 * np.cos(q), "Nm", ("rad",))
    (tmp_path / "next.csv").write_text(csv(then, viscous_machine(then, 2)))
    assert main(["diagnose", first, "--also", str(tmp_path / "next.csv"), "--out", out]) == 0
    found = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [effect["name"] for effect in found["effects"]] == ["viscous_friction"]
    assert found["alternatives"] == []


@pytest.fixture
def diagnosed(tmp_path):
    log = arm_holds(n=120)
    (tmp_path / "log.csv").write_text(csv(log, log.nominal + 0.0 * log.v))
    report = {"effects": [], "alternatives": [], "by_axis": [{"noise": 0.05}]}
    (tmp_path / "report.json").write_text(json.dumps(report))
    return tmp_path


def test_report_without_alternatives_needs_no_plan(diagnosed, capsys):
    assert main(["plan", str(diagnosed / "log.csv"), "--report", str(diagnosed)]) == 0
    assert "nothing to plan" in capsys.readouterr().out
    assert not (diagnosed / "plan.csv").exists()


@pytest.mark.parametrize(
    ("report", "options", "told"),
    [
        (None, [], "no report of this log"),
        ("{", [], "no report of this log"),
        ('{"effects": [], "alternatives": [], "by_axis": [{"noise": 1}, {"noise": 1}]}', [], "2 axes"),
        (
            '{"effects": [], "alternatives": [["magic", "luck"]], "by_axis": [{"noise": 1}]}',
            [],
            "'magic'] are not known",
        ),
        ("", ["--low", "0", "1"], "--low: 2 values for 1 axes"),
        ("", ["--low", "1", "--high", "0"], "low is above high"),
    ],
)
def test_bad_input_of_a_plan_is_one_line(diagnosed, capsys, report, options, told):
    names = ["coulomb_friction", "viscous_friction"]
    default = {
        "effects": [{"name": names[0], "params": {"fc_1": 0.2}}],
        "alternatives": [names],
        "by_axis": [{"noise": 0.05}],
    }
    path = diagnosed / "report.json"
    path.write_text(report or json.dumps(default))
    if report is None:
        path.unlink()
    assert main(["plan", str(diagnosed / "log.csv"), "--report", str(diagnosed), *options]) == 2
    message = capsys.readouterr().err.strip()
    assert told in message
    assert "\n" not in message
    assert not (diagnosed / "plan.csv").exists()


@pytest.mark.parametrize("seed", [20, 22])
def test_blind_set_ends_in_one_name_after_the_planned_measurement(seed):
    outcome = next_motion.run(seed)
    assert outcome.is_planned
    assert outcome.is_one_name
    assert outcome.truth in outcome.named
