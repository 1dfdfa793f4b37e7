"""gravcomp campaign: its route, its journal, its figures, and what it refuses."""

import json
import re
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from gravcomp.campaign import campaign as module
from gravcomp.campaign.campaign import PLAN, Campaign, Plan
from gravcomp.campaign.figures import efforts, noise
from gravcomp.campaign.journal import BEFORE, Journal, joined
from gravcomp.campaign.measuring import RECORDS_OF_HOLD
from gravcomp.campaign.route import HOLD, LEG, ONE_IN, route
from gravcomp.cli import main
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.moving import load_motion
from gravcomp.driver.serial_bus import Line
from gravcomp.errors import InputError
from gravcomp.facts import Cause
from gravcomp.robot.machine import load_machine
from gravcomp.twin.recorder import words_of
from gravcomp_lab.shipped import SPHEIRO, shipped_machine
from support.model_board import ModelBoard
from support.model_mover import WholeModel
from test_py_board import LIMITS, core
from test_py_moving import MOTION, mover


@pytest.mark.parametrize("name", ["spheiro", "slide", "arm2"])
def test_route_spreads_holds_and_keeps_within_the_ranges(name):
    machine = shipped_machine(name)
    steps = route(machine, 40, 8, 3)
    assert steps == route(machine, 40, 8, 3) != route(machine, 40, 8, 4)
    kinds = [step.kind for step in steps]
    assert kinds == [HOLD] * 40 + [LEG] * 8
    for kind in (HOLD, LEG):
        own = [step.is_held_out for step in steps if step.kind == kind]
        assert sum(own) == len(own) // ONE_IN
    low, high = (machine.drive.counts(np.array([getattr(a, name) for a in machine.axes])) for name in ("low", "high"))
    places = np.array([[step.pose, *step.ends] for step in steps])
    assert (places >= low).all()
    assert (places <= high).all()
    holds = places[:40]
    # From both sides, equally far on every axis.
    np.testing.assert_allclose(holds[:, 1] + holds[:, 2], 2 * holds[:, 0], atol=1)
    assert (holds[:, 1] != holds[:, 2]).all()
    # A tour through neighbours is shorter than the order in which poses are drawn.
    drawn = machine.drive.counts(machine.robot.workspace(40, 3))
    assert _way(holds[:, 0]) < 0.7 * _way(drawn)


def _way(counts: np.ndarray) -> float:
    return float(np.abs(np.diff(counts, axis=0)).max(axis=1).sum())


@pytest.mark.parametrize(("poses", "legs"), [(7, 8), (8, 1), (0, 0)])
def test_too_short_a_route_is_refused(poses, legs):
    with pytest.raises(InputError, match="need 8 and 2 at least"):
        route(shipped_machine(), poses, legs, 0)


def record(tick: int, sense_ua: list[int], force_mn: list[int], count: list[int]) -> list[int]:
    axes = zip(count, sense_ua, force_mn, strict=True)
    values = [value for c, s, f in axes for value in (c, 0, s, s, f)]
    assert len(values) + 2 == words_of(len(count))
    return [word % 2**32 for word in (tick, 0b1010, *values)]


def test_journal_keeps_whole_steps_alone_and_joins_sittings(tmp_path):
    path = tmp_path / "journal.jsonl"
    journal = Journal(path)
    journal.add(BEFORE, 0, [record(2**32 - 64, [1], [2], [3]), record(0, [1], [2], [3])], np.zeros((2, 1)))
    journal.add(BEFORE, 4, [record(64, [1], [2], [3])], np.ones((1, 1)))
    whole = path.read_text()
    path.write_text(whole + whole[:40])  # power was cut in the middle of a line
    again = Journal(path)
    assert again.entries == journal.entries
    assert path.read_text() == whole
    assert (again.sitting, again.done(BEFORE)) == (1, {0, 4})
    again.add(BEFORE, 5, [record(7, [1], [2], [3])], np.ones((1, 1)))
    records, velocity = joined(Journal(path).entries, 1)
    # The tick number wraps within a sitting; a core that was switched off begins anew.
    np.testing.assert_array_equal(np.diff(records.tick), [64, 64, 1000])
    assert velocity.shape == (4, 1)
    path.write_text(path.read_text().replace("phase", "stage", 1))
    with pytest.raises(InputError, match=r"journal.jsonl, line 1: is no step of a campaign; delete it"):
        Journal(path)


def test_figures_are_those_of_the_currents(tmp_path):
    """F = K_t i; what the servo adds is F less the feed-forward; noise is the spread within an approach."""
    machine, rng = shipped_machine("slide"), np.random.default_rng(7)
    steps, journal = route(machine, 8, 2, 0), Journal(tmp_path / "j")
    sigma_ua = 2000
    for number in range(8):
        base = int(rng.integers(10**6, 3 * 10**6))
        senses = np.rint(base + sigma_ua * rng.standard_normal(2 * RECORDS_OF_HOLD)).astype(int)
        pose = [steps[number].pose[0] - 3]
        words = [record(k, [int(s)], [45_000], pose) for k, s in enumerate(senses)]
        journal.add(BEFORE, number, words, np.ones((len(words), 1)))
    e = efforts(journal.entries, steps, machine)
    sense = joined(journal.entries, 1)[0].sense
    np.testing.assert_allclose(e.servo, 45.0 * sense * 1e-6 - 45.0)
    assert set(e.error.ravel()) == {3.0}
    spread = 45e-6 * sense.reshape(-1, RECORDS_OF_HOLD).std(axis=1, ddof=1)
    assert noise(journal.entries, machine) == pytest.approx(np.sqrt(np.mean(spread**2)))
    assert noise(journal.entries, machine) == pytest.approx(45e-6 * sigma_ua, rel=0.5)


@pytest.fixture
def limits(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS + MOTION)
    return path


def command(board: ModelBoard, limits, out, *more: str) -> int:
    line = ["--timeout", "3"]
    return main(
        ["campaign", board.port, "--robot", str(SPHEIRO), "--limits", str(limits), "--out", str(out), *line, *more]
    )


def one_line(capsys) -> str:
    text = capsys.readouterr().err
    assert text.startswith("gravcomp campaign: ")
    assert text.count("\n") == 1, text
    return text


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--poses", "3"], "3 poses and 8 legs: need 8 and 2 at least"),
        (["--speed", "0"], "--speed 0: need 0.0001 to 1 ranges per second"),
        (["--speed", "nan"], "--speed nan: need"),
        (["--resume"], "no campaign to resume; leave --resume out"),
        (["--baud", "5"], "--baud 5: need 1200"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_folder(more, words, capsys, tmp_path, limits):
    with ModelBoard(mover()) as board:
        assert command(board, limits, tmp_path / "out", *more) == 2
    assert words in one_line(capsys)
    assert not (tmp_path / "out").exists()


def test_a_core_without_motion_and_another_machine_are_refused(capsys, tmp_path, limits):
    with ModelBoard(core()) as board:
        assert command(board, limits, tmp_path / "out") == 2
    assert "neither moves nor records; build it with motion_g" in one_line(capsys)
    with ModelBoard(core(weights_hash=[1] * 8)) as board:
        assert command(board, limits, tmp_path / "out") == 2
    assert "its ROM has the weights 00000001" in one_line(capsys)
    assert not (tmp_path / "out").exists()


def test_a_folder_is_one_campaign(capsys, tmp_path, limits):
    out, machine = tmp_path / "out", load_machine(SPHEIRO)
    settings, gains = load_limits(limits, SPHEIRO), load_motion(limits, SPHEIRO)
    with ModelBoard(mover()) as model:
        with Board(Line(model.port, timeout_s=3.0)) as board:
            Campaign(board, SPHEIRO, settings, gains, out, Plan(seed=5))
        assert json.loads((out / PLAN).read_text())["machine"] == machine.name
        assert command(model, limits, out, "--seed", "5") == 2
        assert "holds a campaign; go on with it by --resume, or give another folder" in one_line(capsys)
        assert command(model, limits, out, "--seed", "6", "--resume") == 2
        assert "seed is 5, asked for is 6; give what was" in one_line(capsys)
        (out / PLAN).write_text("{")
        assert command(model, limits, out, "--seed", "5", "--resume") == 2
        assert f"{out / PLAN}: cannot be read" in one_line(capsys)


SMALL = ("--poses", "8", "--legs", "2")


def whole() -> WholeModel:
    return mover(partial(WholeModel, load_machine(SPHEIRO), record_s=0.02))


@pytest.mark.slow
def test_command_measures_over_a_line_and_loads_nothing_where_nothing_is_missing(capsys, tmp_path, limits, monkeypatch):
    """A fault stops it at first; nothing of what was measured is lost."""
    out, model_core, reads = tmp_path / "out", whole(), []

    def read(offset: int, plain=model_core.read) -> int:
        reads.append(offset)
        if len(reads) == 6000:
            model_core.fault(Cause.FOLLOWING)
        return plain(offset)

    monkeypatch.setattr(model_core, "read", read)
    with ModelBoard(model_core) as board:
        assert command(board, limits, out, *SMALL) == 2
        complaint = capsys.readouterr().err.splitlines()[-1]
        found = re.search(r"faults: following; .*; (\d+) measured steps are kept in .*, go on with --resume", complaint)
        assert found, complaint
        assert 1 <= int(found[1]) < 10
        assert model_core.get("control") & 1 == 0, "the brakes are asked for"
    with ModelBoard(whole()) as board:
        assert command(board, limits, out, *SMALL, "--resume") == 0
        assert not board.core.image
    assert "nothing loaded: nothing is missing" in capsys.readouterr().out
    content = json.loads((out / "campaign.json").read_text())
    assert (content["schema"], content["held_out"], content["sittings"]) == (1, 3, 2)
    assert content["noise"] == pytest.approx(45e-6 * WholeModel.NOISE_UA, rel=0.3)
    assert (out / "report.html").read_text().count("<svg") == 3 + 1, "one for each axis, and maps"
    with ModelBoard(whole()) as board:  # all is measured: nothing moves
        assert command(board, limits, out, *SMALL, "--resume") == 0
        assert not board.core.targets


def test_a_cure_that_the_core_cannot_hold_is_told_and_not_loaded(tmp_path, limits, monkeypatch):
    """A network that was trained again may not fit the formats of the ROM: that is a result, not the end of it."""

    def refuse(*_):
        raise InputError("output.csv: row 1 does not fit 18 bits")

    entry = SimpleNamespace(name="payload", term=SimpleNamespace(candidate=SimpleNamespace(hardware="network")))
    found = SimpleNamespace(
        fit=SimpleNamespace(effects=[entry], corrections=[]), data=SimpleNamespace(name="before.csv")
    )
    monkeypatch.setattr(module, "close_loop", lambda *_: None)
    monkeypatch.setattr(module, "load_image", refuse)
    with ModelBoard(mover()) as model, Board(Line(model.port, timeout_s=3.0)) as board:
        settings, gains = load_limits(limits, SPHEIRO), load_motion(limits, SPHEIRO)
        campaign = Campaign(board, SPHEIRO, settings, gains, tmp_path / "out", Plan())
        assert campaign._place(found, None) == "output.csv: row 1 does not fit 18 bits"
        found.fit.effects = []
        assert campaign._place(found, None) == "nothing is missing"
        entry.term.candidate.hardware = "none"
        found.fit.effects = [entry]
        assert campaign._place(found, None) == "nothing was found that the hardware can hold"
