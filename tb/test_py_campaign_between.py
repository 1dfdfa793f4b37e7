"""The measurement between two diagnoses of a campaign: its steps are the plan's, and what stops it costs nothing."""

import json
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from gravcomp.campaign import campaign as module
from gravcomp.campaign.between import APPROACH_S, LEAST_LEG_S, _holds, _legs, next_steps, read_next, turns, write_next
from gravcomp.campaign.campaign import NEXT, Campaign, Plan
from gravcomp.campaign.journal import BETWEEN, measured
from gravcomp.campaign.measuring import RECORDS_OF_HOLD
from gravcomp.campaign.route import HOLD, LEG, Step
from gravcomp.commands.campaign import _measure
from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report.folder import write_report
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.moving import load_motion
from gravcomp.driver.serial_bus import Line
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.machine import load_machine
from gravcomp.twin.setpoint import path, rate_of
from gravcomp_lab.shipped import SPHEIRO, shipped_machine
from support.model_board import ModelBoard
from support.model_mover import WholeModel
from test_py_board import LIMITS
from test_py_moving import MOTION, mover

MACHINE = shipped_machine("slide")  # one axis
LOW, HIGH = MACHINE.axes[0].low, MACHINE.axes[0].high
PER_M = MACHINE.drive.counts_per_unit[0]


def as_asked(start, end, seconds: float) -> float:
    return seconds


def log(t_s, q_m, v_mps, friction=lambda v: 0.0 * v, noise_n: float = 0.0) -> Measurement:
    """What the slide's model says, and friction."""
    q, v = np.reshape(q_m, (-1, 1)), np.reshape(v_mps, (-1, 1))
    nominal = MACHINE.robot.forces(q)
    force = nominal + friction(v) + noise_n * np.random.default_rng(5).standard_normal(q.shape)
    return Measurement("log", np.asarray(t_s, float), q, v, force, nominal, "N", ("m",), robot=MACHINE.robot,
                       force_at=MACHINE.robot.forces)  # fmt: skip


def test_turns_are_the_extremes_and_no_ripple():
    t = np.linspace(0.0, 4.0 * np.pi, 4001)
    extremes = np.pi * (np.arange(4) + 0.5)
    found = turns(np.sin(t) + 0.004 * np.sin(90 * t), 0.02)
    assert found[0] == 0  # where it begins
    np.testing.assert_allclose(t[found[1:]], extremes, atol=0.1)
    assert turns(np.linspace(0.0, 1.0, 50), 0.02) == [0]
    assert turns(np.zeros(50), 0.02) == []


def test_planned_motion_becomes_legs_as_long_and_as_fast():
    period_s, cycles = 6.0, 3
    t = np.arange(0.0, (cycles + 0.25) * period_s, 0.05)
    middle, reach = (LOW + HIGH) / 2, 0.3 * (HIGH - LOW)
    rows = log(t, middle + reach * np.sin(2 * np.pi * t / period_s), np.zeros_like(t))
    steps = _legs(MACHINE, rows, as_asked)
    assert {step.kind for step in steps} == {LEG}
    assert [step.number for step in steps] == list(range(len(steps)))
    fro = steps[1:]  # the first goes from the middle to the first turn
    assert len(fro) == cycles
    for step in fro:
        ends = np.array(step.ends)[:, 0] / PER_M
        np.testing.assert_allclose(ends, middle + reach * np.array([1.0, -1.0]), atol=0.01 * reach)
        assert step.seconds == pytest.approx(period_s / 2, abs=0.1)
    assert steps[0].seconds >= LEAST_LEG_S


def test_planned_motion_that_leaves_the_range_is_kept_within_it():
    t = np.arange(0.0, 20.0, 0.05)
    steps = _legs(MACHINE, log(t, (LOW + HIGH) / 2 + (HIGH - LOW) * np.sin(t), np.zeros_like(t)), as_asked)
    places = np.array([step.ends for step in steps]) / PER_M
    assert places.min() >= LOW - 1 / PER_M
    assert places.max() <= HIGH + 1 / PER_M


def test_planned_holds_are_approached_as_the_plan_says():
    rng = np.random.default_rng(3)
    q = rng.uniform(LOW, HIGH, 40)
    q[:2] = LOW, HIGH
    v = rng.choice([-1, 1], 40) * rng.choice([0.001, 0.01, 0.05], 40)
    v[:2] = 0.02, -0.02  # from beyond the range: not possible
    steps = _holds(MACHINE, log(np.arange(40.0), q, v), as_asked)
    assert [step.kind for step in steps] == [HOLD] * 38
    for step, pose, speed in zip(steps, q[2:], v[2:], strict=True):
        (start,) = step.ends
        assert step.pose[0] == round(pose * PER_M)
        assert LOW * PER_M - 1 <= start[0] <= HIGH * PER_M + 1
        assert 0 < step.seconds <= APPROACH_S
        assert (step.pose[0] - start[0]) / PER_M / step.seconds == pytest.approx(speed, abs=1.0 / PER_M / step.seconds)
    slower = _holds(MACHINE, log(np.arange(40.0), q, v), lambda a, b, seconds: 3.0 * seconds)
    assert [a.seconds for a in slower] == pytest.approx([3.0 * b.seconds for b in steps])


@pytest.fixture
def limits(tmp_path):
    file = tmp_path / "limits.toml"
    file.write_text(LIMITS + MOTION)
    return file


@contextmanager
def campaign_in(out, limits, resume=False):
    """A campaign of the Sphe.I.Ro. on a model of a board whose motors do what the robot's model says."""
    whole = mover(partial(WholeModel, load_machine(SPHEIRO), record_s=0.02))
    with ModelBoard(whole) as model, Board(Line(model.port, timeout_s=3.0)) as board:
        settings, gains = load_limits(limits, SPHEIRO), load_motion(limits, SPHEIRO)
        yield Campaign(board, SPHEIRO, settings, gains, out, Plan(poses=8, legs=2), resume=resume)


def test_duration_is_that_of_the_cores_setpoint(tmp_path, limits):
    with campaign_in(tmp_path / "out", limits) as campaign:
        mover, gains = campaign.mover, campaign.mover.gains
        start, end = (0, 0, 0), (90_000, -100, 5)
        for seconds in (0.001, 0.5, 2.0, 10.0):
            rate = rate_of(round(seconds / mover.tick_s), end, gains.speed_max, gains.acceleration_max)
            assert mover.duration_s(start, end, seconds) == pytest.approx(len(path(start, end, rate)) * mover.tick_s)
        assert mover.duration_s(start, end, 10.0) == pytest.approx(10.0, rel=1e-3)
        assert mover.duration_s(start, end, 0.001) > 0.9  # at 100 000 counts/s


def some_steps() -> list[Step]:
    near = (400, -300, 200)
    return [
        Step(HOLD, 0, near, ((0, 0, 0),), False, 0.2),
        Step(LEG, 1, near, (near, (-near[0], 0, near[2])), False, 1.0),
    ]


def test_steps_between_are_kept_measured_and_taken_in_once_they_are_whole(tmp_path, limits, monkeypatch):
    out, asked = tmp_path / "out", []

    def planned(machine, data, report, duration):
        asked.append(len(data.t_s))
        return some_steps(), "two names"

    monkeypatch.setattr(module, "next_steps", planned)
    found = {"alternatives": [["a", "b"]]}
    with campaign_in(out, limits) as campaign:
        assert campaign.plan_between({"alternatives": []}) == 0
        assert not (out / NEXT).exists()
        monkeypatch.setattr(campaign, "_log", lambda: SimpleNamespace(t_s=[0.0] * 7))
        assert campaign.plan_between(found) == 2
        next(campaign.between())  # the line is cut after the first of two
    with campaign_in(out, limits, resume=True) as campaign:
        assert campaign.between_steps == some_steps()
        assert campaign.plan_between(found) == 1, "planned once"
        assert [step.number for step in campaign.between()] == [1]
        assert campaign.plan_between(found) == 0
        assert asked == [7]
        hold, leg = campaign.journal.of(BETWEEN, range(2))
        per_s = np.array(some_steps()[0].pose) * campaign.machine.drive.unit_per_count / 0.2
        np.testing.assert_allclose(hold.velocity, [per_s] * RECORDS_OF_HOLD)
        assert len(leg.words) == len(leg.velocity)
        rows = (measured([hold, leg], campaign.machine, campaign.mover.tick_s)).count("\n") - 1
        assert rows == RECORDS_OF_HOLD + len(leg.words)


def test_log_takes_in_what_came_between_once_it_is_whole(tmp_path, limits, monkeypatch):
    t = np.arange(50.0)
    logs = {"before.csv": log(t, np.full(50, 0.2), 0.0 * t), "between.csv": log(t[:9], np.full(9, 0.25), 0.0 * t[:9])}
    monkeypatch.setattr(module, "read_measurement", lambda file, *_: logs[file.name])
    with campaign_in(tmp_path / "out", limits) as campaign:
        assert len(campaign._log().t_s) == 50
        campaign.between_steps = some_steps()
        assert len(campaign._log().t_s) == 50
        for step in campaign.between_steps:
            campaign.journal.add(BETWEEN, step.number, [], np.zeros((0, 3)))
        both = campaign._log()
        assert len(both.t_s) == 59
        assert both.q[-1, 0] == 0.25


def test_steps_survive_their_file_and_another_file_is_refused(tmp_path):
    write_next(tmp_path / NEXT, some_steps(), "why")
    assert read_next(tmp_path / NEXT) == (some_steps(), "why")
    assert read_next(tmp_path / "none") == ([], "")
    for text in ("{", "[]", '{"why": ""}', json.dumps({"why": "", "steps": [{"kind": "hold"}]})):
        (tmp_path / NEXT).write_text(text)
        with pytest.raises(InputError, match=r"next.json: cannot be read .*; delete it, it is planned again$"):
            read_next(tmp_path / NEXT)


class Told:
    """A campaign that notes what is asked of it; its first diagnosis ends in alternatives, the second does not."""

    def __init__(self, more: int):
        self.held_out, self.more, self.done = {0, 1}, more, []

    def steps_left(self) -> int:
        return 5

    def home(self):
        return iter(())

    def _phase(self, name: str, n: int):
        for _ in range(n):
            yield None
        self.done.append(name)

    before = lambda self: self._phase("before", 3)  # noqa: E731
    after = lambda self: self._phase("after", 2)  # noqa: E731
    between = lambda self: self._phase("between", self.more)  # noqa: E731

    def find(self) -> dict:
        self.done.append("find")
        return {"loads": True, "alternatives": []}

    def plan_between(self, found: dict) -> int:
        return self.more


def test_the_measurement_comes_between_two_diagnoses_on_the_line():
    lines = []

    @contextmanager
    def on_the_line():
        lines.append(1)
        yield

    for more, order in ((0, ["before", "find", "after"]), (4, ["before", "find", "between", "find", "after"])):
        lines.clear()
        campaign = Told(more)
        assert _measure(campaign, lambda states: list(states), on_the_line)["loads"]
        assert campaign.done == order
        assert len(lines) == len(order) - order.count("find")


def test_alternatives_of_a_real_diagnosis_become_steps_of_another_speed(tmp_path):
    """Holds at one speed of approach show viscous friction as Coulomb friction."""
    rng, speed = np.random.default_rng(2), 0.02
    q = rng.uniform(LOW + 0.03, HIGH - 0.03, 60)
    data = log(2.0 * np.arange(60), q, speed * rng.choice([-1, 1], 60), lambda v: 60.0 * v, 0.02)
    data = replace(data, machine=MACHINE) if "machine" in Measurement.__dataclass_fields__ else data
    found = diagnose(data, Model(MACHINE), 0)
    _, content = write_report(found, Model(MACHINE), tmp_path)
    assert any({"coulomb_friction", "viscous_friction"} <= set(names) for names in content["alternatives"]), content
    steps, why = next_steps(MACHINE, data, tmp_path / "report.json", as_asked)
    assert "differ there by" in why
    speeds = [abs(step.pose[0] - step.ends[0][0]) / PER_M / step.seconds for step in steps]
    assert min(speeds) < 0.5 * speed
    assert {step.kind for step in steps} == {HOLD}
