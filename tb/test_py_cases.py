"""Small logs as people have them, made by formula, with the right answer: what is named, what is said, what is refused.

Each stands for a kind of fault: columns that are wrong, positions that read the effort back, samples that are none.
"""

import json

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.diagnosis.candidate import Regressor
from gravcomp.diagnosis.effects.thrust_constant import ThrustConstant
from gravcomp.diagnosis.model import load_model, model_toml
from gravcomp.diagnosis.samples import split
from gravcomp.logs.measurement import Measurement
from machines import MACHINE, SHIPPED
from measured_samples import motion

N = 500
NOISE = 0.05


def arm(n=N, seed=1, dt=0.1):
    """One rotary axis in slow motion with a model of its own: t, q, v, model, noise."""
    t = dt * np.arange(n)
    w = 0.9
    q = 1.1 * np.sin(w * t + 0.3) + 0.4 * np.sin(0.618 * w * t)
    v = 1.1 * w * np.cos(w * t + 0.3) + 0.4 * 0.618 * w * np.cos(0.618 * w * t)
    return t, q, v, 8.0 * np.cos(q), NOISE * np.random.default_rng(seed).standard_normal(n)


def log(**columns) -> str:
    rows = np.column_stack(list(columns.values()))
    return "\n".join([",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n"


def arm_log(force, **others) -> str:
    t, q, v, model, noise = arm()
    return log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=model + force(t, q, v, model) + noise, fm1_nm=model, **others)


def coulomb(t, q, v, model):
    return 0.5 * np.sign(v)


def diagnosed(tmp_path, text, *options, status=0):
    path, out = tmp_path / "log.csv", tmp_path / "out"
    path.write_text(text)
    assert main(["diagnose", str(path), "--out", str(out), *options]) == status
    return json.loads((out / "report.json").read_text()) if status == 0 else None


def names(report) -> set[str]:
    return {effect["name"] for effect in report["effects"]}


def value(report, name, parameter) -> float:
    return next(effect["params"][parameter] for effect in report["effects"] if effect["name"] == name)


def is_said(report, *words) -> bool:
    return any(all(word in note for word in words) for note in report["notes"])


def test_friction_on_a_grid_is_not_taken_for_cogging(tmp_path):
    """A controller without integral stands off its place by effort/stiffness: q reads the effort back."""
    rng = np.random.default_rng(2)
    place = np.deg2rad(np.r_[0:200, 200:0:-1].astype(float))
    v = 0.1 * np.r_[np.ones(200), -np.ones(200)]
    f = 0.02 * np.sign(v) + 0.002 * rng.standard_normal(400)
    found = diagnosed(tmp_path, log(t_s=np.arange(400.0), q1_rad=place - f / 12.0, v1_radps=v, f1_nm=f, fm1_nm=0 * f))
    assert names(found) == {"coulomb_friction"}
    assert found["after"]["rms_n"] == pytest.approx(0.002, rel=0.15)
    assert is_said(found, "q1", "reads the effort back")


def test_friction_without_a_velocity_is_never_nothing(tmp_path):
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.2, 1.2, 300)
    f = 8.0 * np.cos(q) + 0.5 * rng.choice([-1.0, 1.0], 300) + NOISE * rng.standard_normal(300)
    for extra in ({}, {"v1_radps": 0.0 * q}):
        found = diagnosed(tmp_path, log(t_s=np.arange(300.0), q1_rad=q, f1_nm=f, fm1_nm=8.0 * np.cos(q), **extra))
        assert found["verdict"] == "unexplained"
        assert names(found) == set()
        assert is_said(found, "two-valued", "log the approach velocity")
        assert "velocity" in found["untestable"]["coulomb_friction"]


def test_friction_without_a_velocity_and_more_often_one_way_is_no_offset(tmp_path):
    """The median lies within one of the two values; the cut between them does not."""
    rng = np.random.default_rng(15)
    q = rng.uniform(-1.4, 1.4, 150)
    sign = np.where(rng.random(150) < 0.5 - 0.15 * q, -1.0, 1.0)
    f = 8.0 * np.cos(q) + 0.5 * sign + NOISE * rng.standard_normal(150)
    found = diagnosed(tmp_path, log(t_s=np.arange(150.0), q1_rad=q, f1_nm=f, fm1_nm=8.0 * np.cos(q)))
    assert not names(found) - {"current_offset"}
    assert found["verdict"] != "explained"
    assert found["left_out"]["gross_errors"] == 0
    assert is_said(found, "two-valued")


def test_payload_beside_hidden_friction_is_part_of_the_story(tmp_path):
    rng = np.random.default_rng(4)
    q = rng.uniform(-1.2, 1.2, 400)
    f = 8.0 * np.cos(q) + 0.8 * np.sin(q) + 0.5 * rng.choice([-1.0, 1.0], 400) + NOISE * rng.standard_normal(400)
    found = diagnosed(tmp_path, log(t_s=np.arange(400.0), q1_rad=q, f1_nm=f, fm1_nm=8.0 * np.cos(q)))
    assert found["verdict"] == "partly_explained"
    assert is_said(found, "two-valued")


def test_step_of_friction_is_named_and_no_fit_is_worse_than_none(tmp_path):
    found = diagnosed(tmp_path, arm_log(lambda t, q, v, model: np.where(t > 25.0, 1.2, 0.4) * np.sign(v)))
    assert {"coulomb_friction", "friction_step"} == names(found)
    assert value(found, "friction_step", "step_1") == pytest.approx(0.8, abs=0.05)
    assert value(found, "friction_step", "t_step_s") == pytest.approx(25.0, abs=1.0)
    assert found["after"]["rms_n"] < 1.2 * NOISE


@pytest.mark.parametrize("kind", ["friction_step", "offset_step"])
def test_step_among_held_out_rows_spoils_no_verdict(tmp_path, kind):
    """No training row tells when in the gap it came: the rows between are not judged, and that is said."""
    t, q, v, model, noise = arm()
    data = Measurement("log", t, q[:, None], v[:, None], model[:, None], model[:, None], "Nm", ("rad",))
    is_test = split.held_out(data, split.block_labels(data, 0), 0)
    first = next(k for k in range(150, 350) if is_test[k] and not is_test[k - 1])
    size = np.sign(v) if kind == "friction_step" else 1.0
    f = model + np.where(np.arange(N) > first + 1, 1.0, 0.0) * size + noise
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=model))
    assert kind in names(found)
    assert found["verdict"] == "explained"
    assert is_said(found, "rows are not judged")


def test_late_effort_is_a_lag_and_no_backlash(tmp_path):
    moved = motion(2000)
    friction = 2.0 * np.sign(moved.v)
    late = np.column_stack([np.interp(moved.t_s - 0.25, moved.t_s, f) for f in (moved.nominal + friction).T])
    late += 0.15 * np.random.default_rng(5).standard_normal(late.shape)
    columns = {f"q{i + 1}_m": moved.q[:, i] for i in range(3)} | {f"v{i + 1}_mps": moved.v[:, i] for i in range(3)}
    columns |= {f"f{i + 1}_n": late[:, i] for i in range(3)}
    found = diagnosed(tmp_path, log(t_s=moved.t_s, **columns), "--robot", str(SHIPPED))
    assert names(found) == {"sensor_lag", "coulomb_friction"}
    assert value(found, "sensor_lag", "tau_s") == pytest.approx(0.25, abs=0.02)
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(2.0, abs=0.05)


def vertical(n=900, dt=0.05):
    """A linear axis under a constant load: t, q, v, noise."""
    t = dt * np.arange(n)
    q = 0.2 * (np.sin(0.83 * t + 1.0) + 0.4 * np.sin(0.51 * t + 2.0))
    v = 0.2 * (0.83 * np.cos(0.83 * t + 1.0) + 0.4 * 0.51 * np.cos(0.51 * t + 2.0))
    return t, q, v, 0.3 * np.random.default_rng(12).standard_normal(n)


def test_late_effort_is_a_lag_where_the_model_is_constant(tmp_path):
    """The jumps of friction alone tell: late by a time, not by a travel."""
    t, q, v, noise = vertical()
    f = 40.0 + 2.0 * np.sign(np.interp(t - 0.2, t, v)) + noise
    found = diagnosed(tmp_path, log(t_s=t, q1_m=q, v1_mps=v, f1_n=f, fm1_n=np.full(len(t), 40.0)))
    assert names(found) == {"sensor_lag", "coulomb_friction"}
    assert value(found, "sensor_lag", "tau_s") == pytest.approx(0.2, abs=0.02)
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(2.0, abs=0.06)


def test_how_a_motion_began_is_no_step_of_friction(tmp_path):
    """A slide that was pushed back before: its friction pulls the other way until it has come some travels far, which
    takes a slow start long. z = 1 - 2 exp(-way/s) until the first reversal.
    """
    t = 0.1 * np.arange(800)
    speed = 0.05 * np.sin(0.25 * np.maximum(t - 6.0, 0.0)) + 0.001 * np.minimum(t / 6.0, 1.0)
    q = np.cumsum(speed) * 0.1
    z, state = np.empty_like(t), -1.0
    for k, step in enumerate(np.diff(q, prepend=0.0)):
        state = np.sign(step) + (state - np.sign(step)) * np.exp(-abs(step) / 0.004)
        z[k] = state
    noise = NOISE * np.random.default_rng(3).standard_normal(len(t))
    text = log(t_s=t, q1_m=q, v1_mps=speed, f1_n=5.0 + 0.6 * z + noise, fm1_n=5.0 + 0.0 * t)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"presliding_hysteresis"}
    assert value(found, "presliding_hysteresis", "s_1") == pytest.approx(0.004, rel=0.2)


@pytest.mark.parametrize("turns", [2.6, 2.9, 3.0])
def test_cogging_of_three_turns_over_the_range_is_named(tmp_path, turns):
    t, q, v, _, noise = arm(1500)
    span = np.ptp(q)
    ripple = 0.2 * np.sin(2.0 * np.pi * turns * q / span + 0.7)
    text = log(t_s=t, q1_m=q, v1_mps=v, f1_n=20.0 + ripple + noise, fm1_n=20.0 + 0.0 * t)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"cogging"}
    assert value(found, "cogging", "pitch") == pytest.approx(span / turns, rel=0.02)


def test_friction_that_settles_along_a_travel_is_no_lag(tmp_path):
    """Dahl's friction is late, too, but by a travel."""
    t, q, v, noise = vertical()
    z = np.zeros(len(t))
    for k in range(1, len(t)):
        d = q[k] - q[k - 1]
        z[k] = np.sign(d) + (z[k - 1] - np.sign(d)) * np.exp(-abs(d) / 0.01)
    found = diagnosed(tmp_path, log(t_s=t, q1_m=q, v1_mps=v, f1_n=40.0 + 4.0 * z + noise, fm1_n=np.full(len(t), 40.0)))
    assert names(found) == {"presliding_hysteresis"}


def test_long_lag_is_found_whole(tmp_path):
    """tau df/dt is a lag to first order only: 0.2 s at a quarter of a turn per second are more."""
    t, q, v, _, noise = arm(900, dt=0.05)
    f = np.interp(t - 0.2, t, 2.0 * np.cos(2.0 * q)) + 0.2 * noise
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=2.0 * np.cos(2.0 * q)))
    assert names(found) == {"sensor_lag"}
    assert value(found, "sensor_lag", "tau_s") == pytest.approx(0.2, abs=0.003)


def test_lag_is_found_beside_a_large_effect(tmp_path):
    """A ripple of ten times the noise, late as all is: what is late of the model is small beside it."""
    t = 0.05 * np.arange(700)
    q = 1.1 * (np.sin(0.9 * t + 0.3) + 0.35 * np.sin(0.618 * 0.9 * t))
    v = 1.1 * 0.9 * (np.cos(0.9 * t + 0.3) + 0.35 * 0.618 * np.cos(0.618 * 0.9 * t))
    model, noise = 5.0 * np.cos(q), 0.04 * np.random.default_rng(5).standard_normal(700)
    f = np.interp(t - 0.1, t, model + 0.6 * np.sin(12.0 * q + 0.5)) + noise
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=model))
    assert names(found) == {"sensor_lag", "cogging"}
    assert found["verdict"] == "explained"
    assert value(found, "sensor_lag", "tau_s") == pytest.approx(0.1, abs=0.005)
    assert value(found, "cogging", "amplitude_1_h1") == pytest.approx(0.6, abs=0.02)


@pytest.mark.parametrize("value_nm", [0.0, 7.25])
def test_rows_with_a_stuck_effort_are_left_out_and_counted(tmp_path, value_nm):
    """A drive that was off, a bus that lost its words: as many rows as no gross error has."""
    t, q, v, model, noise = arm()
    f = model + coulomb(t, q, v, model) + noise
    f[200:230] = value_nm
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=model))
    assert names(found) == {"coulomb_friction"}
    assert found["verdict"] == "explained"
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(0.5, abs=0.02)
    assert any("axis 1 is stuck" in note and "30 rows" in note for note in found["notes"])


@pytest.mark.parametrize("step_nm", [0.05, 0.5])
def test_coarse_converter_is_not_stuck(tmp_path, step_nm):
    """At a turning point the same number stands for many rows, with no leap beside them."""
    t, q, v, model, noise = arm()
    f = np.round((model + 0.2 * noise) / step_nm) * step_nm
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=model))
    assert not any("stuck" in note for note in found["notes"])


def test_friction_keeps_its_name_beside_a_bump_where_the_model_is_constant(tmp_path):
    """What contains Coulomb's friction, or is the same under a constant load, is no other explanation of it."""
    t, q, v, noise = vertical()
    f = 40.0 + 2.5 * np.sign(v) + 2.5 * np.exp(-(((q - 0.045) / 0.018) ** 2)) + noise
    found = diagnosed(tmp_path, log(t_s=t, q1_m=q, v1_mps=v, f1_n=f, fm1_n=np.full(len(t), 40.0)))
    assert names(found) == {"coulomb_friction"}
    assert found["verdict"] == "partly_explained"


def test_drag_with_the_square_of_the_speed_is_no_viscous_friction(tmp_path):
    """No larger than the noise: a line through it leaves a fifth of it, and the verdict said all was explained."""
    t, q, v, noise = vertical()
    drag = 0.3 * v * np.abs(v) / np.sqrt(np.mean(v**4))
    found = diagnosed(tmp_path, log(t_s=t, q1_m=q, v1_mps=v, f1_n=40.0 + drag + noise, fm1_n=np.full(len(t), 40.0)))
    assert names(found) == set()
    assert found["verdict"] == "unexplained"
    assert found["drivers"][0]["variable"] == "v1"


@pytest.mark.parametrize(("factor", "words"), [(1000.0, ("v1", "thousand")), (-1.0, ("v1", "wrong sign"))])
def test_velocity_is_checked_against_the_positions(tmp_path, factor, words):
    t, q, v, model, noise = arm()
    text = log(t_s=t, q1_rad=q, v1_radps=factor * v, f1_nm=model + 0.5 * np.sign(v) + noise, fm1_nm=model)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"coulomb_friction"}
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(0.5, abs=0.02)
    assert is_said(found, *words)


def test_noisy_velocity_is_no_presliding(tmp_path):
    t, q, v, model, noise = arm()
    rough = v + 0.15 * np.random.default_rng(6).standard_normal(N)
    text = log(t_s=t, q1_rad=q, v1_radps=rough, f1_nm=model + 0.5 * np.sign(v) + noise, fm1_nm=model)
    assert names(diagnosed(tmp_path, text)) == {"coulomb_friction"}


def test_effort_of_the_wrong_sign_is_that_and_no_gain(tmp_path):
    t, q, v, model, noise = arm()
    text = log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=-(model + 0.5 * np.sign(v) + noise), fm1_nm=model)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"sensor_sign", "coulomb_friction"}
    assert value(found, "sensor_sign", "sign_1") == -1.0
    again = diagnosed(tmp_path, text, "--robot", str(tmp_path / "out" / "model.toml"))
    assert again["verdict"] == "nothing_missing"


def test_gain_of_a_unit_is_no_thrust_constant(tmp_path):
    t, q, v, model, noise = arm()
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=10.0 * model + noise, fm1_nm=model))
    assert "thrust_constant" not in names(found)
    assert is_said(found, "axis 1", "times the model", "unit")


def test_search_seeks_a_gain_only_where_the_effort_is_near_the_model():
    """What the log calls a unit or a sign, an effort of 0.3 times the model, is named no gain of -0.5 beside it."""
    t, q, v, model, noise = arm()
    position, speed, both = (np.column_stack([x, x]) for x in (q, v, model))
    effort = np.column_stack([1.2 * model + noise, 0.3 * model + noise])
    data = Measurement("log", t, position, speed, effort, both, "Nm", ("rad", "rad"))
    found = Regressor.of(ThrustConstant(), data, np.arange(N))
    assert found.term.labels == ("gain_1",)
    np.testing.assert_array_equal(found.by_axis[0], model[:, None])
    assert found.by_axis[1] is None


def test_spikes_are_left_out_and_counted(tmp_path):
    def spiked(at: dict[int, float]) -> str:
        lines = arm_log(coulomb).splitlines()
        for row, size in at.items():
            cells = lines[row].split(",")
            lines[row] = ",".join([*cells[:3], str(size), cells[4]])
        return "\n".join(lines) + "\n"

    plain = diagnosed(tmp_path, spiked({}))
    for at, counted in (
        ({50: 1000.0, 217: 1000.0}, {"gross_errors": 0, "missing_values": 2}),
        ({40: -99999.0}, {"gross_errors": 0, "missing_values": 1}),
        ({60: 41.0, 90: -37.0, 333: 29.0}, {"gross_errors": 3, "missing_values": 0}),
    ):
        found = diagnosed(tmp_path, spiked(at))
        assert names(found) == {"coulomb_friction"}
        assert found["left_out"] == counted
        assert found["after"]["rms_n"] == pytest.approx(plain["after"]["rms_n"], rel=0.15)
        assert found["noise_floor_n"] == pytest.approx(NOISE, rel=0.15)


def test_repeated_stamp_costs_no_velocity(tmp_path):
    t, q, v, model, noise = arm()
    t[100] = t[99]
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, f1_nm=model + 0.5 * np.sign(v) + noise, fm1_nm=model))
    assert names(found) == {"coulomb_friction"}


@pytest.mark.parametrize("has_v", [True, False])
def test_stamps_that_jitter_are_found_and_put_right(tmp_path, has_v):
    """Even samples, stamps 20 ms off at 100 ms: a derivative along them is wrong."""
    t, q, v, model, noise = arm()
    stamps = t + 0.02 * np.random.default_rng(8).standard_normal(N)
    speed = {"v1_radps": v} if has_v else {}
    text = log(t_s=stamps, q1_rad=q, **speed, f1_nm=model + 0.5 * np.sign(v) + 0.2 * v + noise, fm1_nm=model)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"coulomb_friction", "viscous_friction"}
    assert value(found, "viscous_friction", "b_1") == pytest.approx(0.2, abs=0.03)
    assert is_said(found, "t_s", "jitter", "even clock")


def test_samples_that_were_taken_unevenly_keep_their_stamps(tmp_path):
    even = 0.1 * np.arange(N) + 0.02 * np.random.default_rng(8).standard_normal(N)
    q, v = 1.1 * np.sin(0.9 * even), 0.99 * np.cos(0.9 * even)
    f = 8.0 * np.cos(q) + 0.5 * np.sign(v) + NOISE * np.random.default_rng(1).standard_normal(N)
    found = diagnosed(tmp_path, log(t_s=even, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=8.0 * np.cos(q)))
    assert names(found) == {"coulomb_friction"}
    assert not is_said(found, "jitter")


def held(values: np.ndarray, rows: int) -> np.ndarray:
    return values[np.arange(len(values)) // rows * rows]


@pytest.mark.parametrize("column", ["f", "q", "q and v", "q without v"])
def test_column_of_a_slower_clock_is_found_and_put_right(tmp_path, column):
    """Held over eight rows, 0.32 s: as late as a lag of half of it, and no presliding, backlash or cogging."""
    t, q, v, model, noise = arm(2000, dt=0.04)
    f = model + 0.5 * np.sign(v) + noise
    f = held(f, 8) if column == "f" else f
    q, own = (held(q, 8), model) if "q" in column else (q, model)
    v = held(v, 8) if "v" in column and "without" not in column else v
    if "q" in column:
        own = held(own, 8)
    speed = {} if "without" in column else {"v1_radps": v}
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, **speed, f1_nm=f, fm1_nm=own))
    assert names(found) == {"coulomb_friction"}
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(0.5, abs=0.02)
    assert is_said(found, "stands for 8 rows at a time")
    assert found["after_without_reversals"]["rms_n"] < 1.2 * NOISE


def test_steps_of_a_converter_are_no_slower_clock(tmp_path):
    t, q, v, model, noise = arm(2000, dt=0.02)
    f = 0.1 * np.round((model + 0.5 * np.sign(v) + 0.2 * noise) / 0.1)
    found = diagnosed(tmp_path, log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=f, fm1_nm=model))
    assert "coulomb_friction" in names(found)
    assert not is_said(found, "rows at a time")


def test_late_velocity_is_a_lag_of_its_own(tmp_path):
    """0.3 s late: at each reversal the sign of v is that of before."""
    t, q, v, model, noise = arm(2000, dt=0.02)
    late = np.interp(t - 0.3, t, v)
    text = log(t_s=t, q1_rad=q, v1_radps=late, f1_nm=model + 0.5 * np.sign(v) + 0.3 * v + noise, fm1_nm=model)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"sensor_lag", "coulomb_friction", "viscous_friction"}
    assert value(found, "sensor_lag", "tau_v_1") == pytest.approx(0.3, abs=0.02)
    assert value(found, "viscous_friction", "b_1") == pytest.approx(0.3, abs=0.02)
    assert "check the filter of the velocity" in found["next"]
    again = diagnosed(tmp_path, text, "--robot", str(tmp_path / "out" / "model.toml"))
    assert again["verdict"] == "nothing_missing"


def test_restart_of_the_clock_is_a_second_run(tmp_path):
    lines = arm_log(coulomb).splitlines()
    found = diagnosed(tmp_path, "\n".join([*lines, *lines[1:300]]) + "\n")
    assert names(found) == {"coulomb_friction"}
    assert is_said(found, "restarts in row 502", "2 runs")
    assert "restarts in row 502" in (tmp_path / "out" / "report.html").read_text()


def test_epoch_in_nanoseconds_is_a_time(tmp_path):
    t, q, v, model, noise = arm()
    stamps = [f"{1_700_000_000_000_000_000 + int(1e9 * x):d}" for x in t]
    rows = np.column_stack([q, model + 0.5 * np.sign(v) + noise, model])
    lines = [f"{s}," + ",".join(f"{x:.9g}" for x in row) for s, row in zip(stamps, rows, strict=True)]
    found = diagnosed(tmp_path, "\n".join(["t_s,q1_rad,f1_nm,fm1_nm", *lines]) + "\n")
    assert names(found) == {"coulomb_friction"}
    assert is_said(found, "1970", "ns")


def test_friction_that_grows_along_the_travel_is_no_backlash(tmp_path):
    found = diagnosed(tmp_path, arm_log(lambda t, q, v, model: (0.6 + 0.3 * q) * np.sign(v)))
    assert names(found) == {"position_dependent_friction"}
    assert value(found, "position_dependent_friction", "slope_1") == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize("temp", [None, "noise", "constant"])
def test_column_more_takes_no_candidate_away(tmp_path, temp):
    noisy = 25.0 + np.random.default_rng(7).standard_normal(N)
    extra = {} if temp is None else {"temp_c": noisy if temp == "noise" else np.full(N, 25.0)}
    found = diagnosed(tmp_path, arm_log(lambda t, q, v, model: -0.15 * (1 - np.exp(-t / 10.0)) * model, **extra))
    assert names(found) == {"thermal_drift"}
    assert value(found, "thermal_drift", "tau_s") == pytest.approx(10.0, abs=2.0)


def test_fine_ripple_is_cogging_and_no_noise(tmp_path):
    t, q, v, model, noise = arm(3000, dt=0.02)
    ripple = 0.4 * np.sin(202 * q + 0.4)
    text = log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=model + 0.3 * np.sign(v) + ripple + noise, fm1_nm=model)
    found = diagnosed(tmp_path, text)
    assert names(found) == {"coulomb_friction", "cogging"}
    assert found["noise_floor_n"] == pytest.approx(NOISE, rel=0.1)


def test_jump_of_friction_is_no_noise(tmp_path):
    """One vertical axis: the model is constant, and friction much larger than the noise."""
    t = 0.02 * np.arange(3000)
    q, v = 0.2 * np.sin(0.5 * t + 0.2), 0.1 * np.cos(0.5 * t + 0.2)
    f = 118.0 + 20.0 * np.sign(v) + 80.0 * v + 0.3 * np.random.default_rng(8).standard_normal(3000)
    found = diagnosed(tmp_path, log(t_s=t, q1_m=q, v1_mps=v, f1_n=f, fm1_n=np.full(3000, 118.0)))
    assert names(found) == {"coulomb_friction", "viscous_friction"}
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(20.0, abs=0.15)
    assert value(found, "viscous_friction", "b_1") == pytest.approx(80.0, abs=3.0)
    assert found["noise_floor_n"] == pytest.approx(0.3, rel=0.1)


def test_small_effect_beside_a_large_one_is_kept_where_the_evidence_is(tmp_path):
    t, q, v, model, noise = arm()
    text = log(t_s=t, q1_rad=q, v1_radps=v, f1_nm=model + 3.0 * np.sign(v) + 0.15 * v + 0.4 * noise, fm1_nm=model)
    found = diagnosed(tmp_path, text)
    assert {"coulomb_friction", "viscous_friction"} <= names(found)
    low, high = next(e["ci95"]["fc_1"] for e in found["effects"] if e["name"] == "coulomb_friction")
    assert low < 3.0 < high


def test_change_may_be_negative_where_the_model_has_too_much(tmp_path):
    text = arm_log(coulomb)
    diagnosed(tmp_path, text)
    model = tmp_path / "out" / "model.toml"
    model.write_text(model.read_text() + '\n[[effects]]\nname = "coulomb_friction"\n[effects.params]\nfc_1 = 0.3\n')
    found = diagnosed(tmp_path, text, "--robot", str(model))
    assert names(found) == {"coulomb_friction"}
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(-0.3, abs=0.02)
    assert is_said(found, "too much coulomb_friction")


def test_friction_that_falls_with_speed_changes_a_model_of_constant_friction(tmp_path):
    """0.6 at rest and 0.3 at speed, where the model has 0.5 at both: more at rest, less at speed."""
    text = arm_log(lambda t, q, v, model: (0.3 + 0.3 * np.exp(-((v / 0.25) ** 2))) * np.sign(v))
    model = tmp_path / "m.toml"
    model.write_text('[[effects]]\nname = "coulomb_friction"\n[effects.params]\nfc_1 = 0.5\n')
    found = diagnosed(tmp_path, text, "--robot", str(model))
    assert names(found) == {"stribeck_friction"}
    assert value(found, "stribeck_friction", "fs_1") == pytest.approx(0.1, abs=0.06)
    assert value(found, "stribeck_friction", "fc_1") == pytest.approx(-0.2, abs=0.04)


def test_unexplained_structure_is_never_explained(tmp_path):
    """Friction is right, but a bump over the position is left that no effect has."""
    bump = lambda t, q, v, model: 0.5 * np.sign(v) + 0.5 * np.exp(-(((q - 0.4) / 0.1) ** 2))  # noqa: E731
    found = diagnosed(tmp_path, arm_log(bump))
    assert found["verdict"] in ("partly_explained", "unexplained")
    assert found["noise_model_free_n"] < 2.0 * NOISE


UNITS = {
    "deg": ({"q1_rad": ("q1_deg", 180 / np.pi), "v1_radps": ("v1_degps", 180 / np.pi)}, "deg converted to rad"),
    "milli": ({"f1_nm": ("f1_mnm", 1e3), "fm1_nm": ("fm1_mnm", 1e3)}, "mnm converted to nm"),
    "drive": ({"f1_nm": ("f1_permille", 20.0)}, "permille converted to nm"),
}


@pytest.mark.parametrize("unit", UNITS)
def test_known_units_are_converted_and_said(tmp_path, unit):
    t, q, v, model, noise = arm()
    columns = {"t_s": t, "q1_rad": q, "v1_radps": v, "f1_nm": model + 0.5 * np.sign(v) + noise, "fm1_nm": model}
    renamed, told = UNITS[unit]
    text = log(**{renamed.get(k, (k,))[0]: x * renamed.get(k, (k, 1.0))[1] for k, x in columns.items()})
    options = ("--units", "permille=0.05nm") if unit == "drive" else ()
    found = diagnosed(tmp_path, text, *options)
    assert value(found, "coulomb_friction", "fc_1") == pytest.approx(0.5, abs=0.02)
    assert is_said(found, told)


def test_unit_of_the_drive_asks_for_its_size(tmp_path, capsys):
    t, q, _, model, _ = arm()
    text = log(t_s=t, q1_rad=q, f1_permille=20.0 * model, fm1_nm=model)
    diagnosed(tmp_path, text, status=2)
    assert "say it with --units permille=" in capsys.readouterr().err


def test_axes_in_metres_and_radians_are_one_machine(tmp_path):
    t, q, v, model, noise = arm()
    slide, speed = 0.2 * np.sin(0.7 * t), 0.14 * np.cos(0.7 * t)
    f2 = 30.0 + 2.0 * np.sign(speed) + 0.2 * np.random.default_rng(9).standard_normal(N)
    text = log(t_s=t, q1_rad=q, q2_m=slide, v1_radps=v, v2_mps=speed, f1_nm=model + 0.5 * np.sign(v) + noise, f2_n=f2,
               fm1_nm=model, fm2_n=np.full(N, 30.0))  # fmt: skip
    found = diagnosed(tmp_path, text)
    assert names(found) == {"coulomb_friction"}
    assert value(found, "coulomb_friction", "fc_2") == pytest.approx(2.0, abs=0.05)
    assert found["unit"] == "Nm, N"


ROBOT = MACHINE.text
COULOMB = '[[effects]]\nname = "coulomb_friction"\n[effects.params]\nfc_1 = 0.5\n'
TABLE = ('[[empirical]]\naxis = 1\nkind = "table"\nvariables = ["q1"]\nby_direction = false\n'
         "shape = [-1.0, 0.0, 1.0]\nvalues = [0.1, 0.2, 0.3]\n")  # fmt: skip
WRONG = {
    "key": (COULOMB.replace("fc_1", "fc1"), "fc1 is none of its parameters"),
    "parms": (COULOMB.replace("params", "parms"), "parms is not known; name it params"),
    "efects": (COULOMB.replace("effects", "efects"), "[[efects]] is not known; name it [[effects]]"),
    "table of effects": ('[effects]\nname = "coulomb_friction"\n', "write [[effects]]"),
    "params as list": ('[[effects]]\nname = "coulomb_friction"\nparams = [1, 2]\n', "write [effects.params]"),
    "huge": (COULOMB.replace("0.5", "1e300"), "fc_1 = 1e+300 is not a finite number"),
    "huge integer": (COULOMB.replace("0.5", "1" + "0" * 400), "is not a finite number"),
    "axis 4": (COULOMB.replace("fc_1", "fc_4"), "fc_4: the robot has axes 1..3"),
    "pitch 0": ('[[effects]]\nname = "cogging"\n[effects.params]\npitch = 0.0\n', "pitch = 0.0 is out of range"),
    "tau 0": ('[[effects]]\nname = "thermal_drift"\n[effects.params]\ngain_1 = 0.1\ntau_s = 0.0\n', "tau_s = 0.0"),
    "kind": (TABLE.replace("table", "tabel"), "kind = 'tabel' is not known; use one of table"),
    "axis 0": (TABLE.replace("axis = 1", "axis = 0"), "axis = 0 is no axis"),
    "axis 7": (TABLE.replace("axis = 1", "axis = 7"), "the robot has axes 1..3"),
    "direction": (TABLE.replace("false", '"false"'), "by_direction = 'false' is not true or false"),
    "nan": (TABLE.replace("0.2", "nan"), "values = nan is not a finite number"),
    "too few values": (TABLE.replace("0.1, ", ""), "values: 2 where this shape has 3"),
    "no shape": (TABLE.replace("[-1.0, 0.0, 1.0]", "[]"), "shape: [] is no shape of a table"),
    "variable": (TABLE.replace("q1", "zz"), "'zz' is no variable"),
}


@pytest.fixture(scope="module")
def robot_log() -> str:
    moved = motion(200)
    columns = {f"q{i + 1}_m": moved.q[:, i] for i in range(3)} | {f"v{i + 1}_mps": moved.v[:, i] for i in range(3)}
    return log(t_s=moved.t_s, **columns, **{f"f{i + 1}_n": moved.nominal[:, i] for i in range(3)})


@pytest.mark.parametrize("case", WRONG)
def test_model_with_a_slip_ends_in_one_line_with_key_and_mend(tmp_path, capsys, robot_log, case):
    text, told = WRONG[case]
    (tmp_path / "m.toml").write_text(f"{ROBOT}\n{text}")
    diagnosed(tmp_path, robot_log, "--robot", str(tmp_path / "m.toml"), status=2)
    message = capsys.readouterr().err.strip()
    assert told in message
    assert "\n" not in message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("order", ["first", "inline"])
def test_model_is_read_in_any_order_and_written_once(tmp_path, order):
    text = ROBOT.replace("[network]", f"{COULOMB}[network]") if order == "first" else (
        f'effects = [{{name = "coulomb_friction", params = {{fc_1 = 0.5}}}}]\n{ROBOT}')  # fmt: skip
    (tmp_path / "m.toml").write_text(text)
    model = load_model(tmp_path / "m.toml")
    (tmp_path / "again.toml").write_text(model_toml(model))
    again = load_model(tmp_path / "again.toml")
    assert again.effects == model.effects == [("coulomb_friction", {"fc_1": 0.5})]
    assert again.machine.robot.parameters.d_m == model.machine.robot.parameters.d_m


def test_own_model_is_read_back_on_a_log_with_less(tmp_path):
    text = arm_log(lambda t, q, v, model: 0.5 * np.sign(v) + 0.4 * np.exp(-(((q - 0.4) / 0.2) ** 2)))
    diagnosed(tmp_path, text)
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.2, 1.2, 100)
    poor = log(t_s=np.arange(100.0), q1_rad=q, f1_nm=8.0 * np.cos(q) + 0.05 * rng.standard_normal(100),
               fm1_nm=8.0 * np.cos(q))  # fmt: skip
    found = diagnosed(tmp_path, poor, "--robot", str(tmp_path / "out" / "model.toml"))
    assert is_said(found, "the model's coulomb_friction is left aside", "no velocity")


@pytest.mark.parametrize("seed", ["-1", "4294967296"])
def test_seed_that_is_none_is_refused(tmp_path, capsys, robot_log, seed):
    (tmp_path / "log.csv").write_text(robot_log)
    with pytest.raises(SystemExit, match="2"):
        main(["diagnose", str(tmp_path / "log.csv"), "--out", str(tmp_path / "out"), f"--seed={seed}"])
    assert "is no seed" in capsys.readouterr().err


def test_folder_is_looked_at_before_the_work(tmp_path, capsys, robot_log, monkeypatch):
    (tmp_path / "out").write_text("a file")
    monkeypatch.setattr("gravcomp.diagnosis.diagnosis.diagnose", lambda *a: pytest.fail("the work was begun"))
    diagnosed(tmp_path, robot_log, status=2)
    assert "is a file; give a folder" in capsys.readouterr().err
