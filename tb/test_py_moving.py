"""gravcomp board PORT move and record, against a model behind a pseudo terminal: targets, records, CSV, refusals."""

import re

import numpy as np
import pytest

from codes import ROOT
from gravcomp.cli import main
from gravcomp.driver.moving import load_motion
from gravcomp.errors import InputError
from gravcomp.facts import Cause, State
from gravcomp.robot.machine import load_machine
from support.model_board import ModelBoard, Noise
from support.model_mover import FORCE_MN, SENSE_OFFSET_UA, ModelMover
from test_py_board import LIMITS, SPHEIRO, TIMEOUT_S, core, one_line

MOTION = """
[motion]
stiffness_ua_per_count = 40.0
integral_ua_per_count_s = [600, 500, 400]
damping_ua_s_per_count = 0.8
filter = 2
servo_limit_ua = 1000000
following_counts = 2000
speed_counts_per_s = 100000
acceleration_counts_per_s2 = 1000000
"""
# As test_py_board.core, and it moves.
GEOMETRY = 4 | 1 << 16


def mover(make=ModelMover, **changes) -> ModelMover:
    braked = core()
    values = {name: braked.get(name) for name in ("clock_hz", "geometry", "encoder_flags", "guards")}
    values["weights_hash"] = [braked.get("weights_hash", k) for k in range(8)]
    values["trained_low"], values["trained_high"] = [2**32 - 200_000] * 3, [200_000] * 3
    return make(**values | {"encoder_geometry": GEOMETRY} | changes)


@pytest.fixture
def limits(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS + MOTION)
    return path


def run(model: ModelBoard, verb: str, limits, *arguments: str) -> int:
    common = ("--timeout", str(TIMEOUT_S), "--robot", str(SPHEIRO), "--limits", str(limits))
    return main(["board", model.port, verb, *common, *arguments])


def last_line(capsys) -> str:
    """The complaint, behind what was shown of the way to it."""
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("gravcomp board: ")]
    assert len(lines) == 1
    return lines[0]


def read_csv(path) -> tuple[list[str], np.ndarray]:
    header, *rows = path.read_text().splitlines()
    return header.split(","), np.array([[float(x) for x in row.split(",")] for row in rows])


def test_move_goes_to_each_pose_and_writes_what_was_measured(limits, tmp_path, capsys):
    out, model_core = tmp_path / "measured.csv", mover()
    poses = ("--to", "0.01", "-0.02", "0.0", "--to", "0", "0", "0.005")
    with ModelBoard(model_core, Noise(lost_answers=0.02, seed=5)) as model:
        assert run(model, "move", limits, *poses, "--seconds", "0.1", "--hold", "0.3", "--out", str(out)) == 0
    assert model_core.targets == [[10_000, 2**32 - 20_000, 0], [0, 0, 5000]]
    assert model_core.get("control") & 1 == 0, "the brakes are asked for again"
    header, rows = read_csv(out)
    assert header == ["t_s", *(f"q{k}_m" for k in (1, 2, 3)), *(f"v{k}_mps" for k in (1, 2, 3)),
                      *(f"i{k}_a" for k in (1, 2, 3))]  # fmt: skip
    # Every record once and in order: the tick is the number of the record, so is each current but for its offset.
    number = np.rint(rows[:, 0] / 100e-6).astype(int)
    np.testing.assert_array_equal(number, np.arange(len(rows)))
    assert len(rows) > 10
    for axis in range(3):
        np.testing.assert_allclose(rows[:, 7 + axis], (1000 * number + axis + SENSE_OFFSET_UA) * 1e-6, rtol=1e-9)
    assert {tuple(row) for row in rows[:, 1:4]} >= {(0.01, -0.02, 0.0), (0.0, 0.0, 0.005)}
    assert f"{out}: {len(rows)} records" in capsys.readouterr().out


def test_record_holds_and_writes_commands_where_none_are_measured(limits, tmp_path, capsys):
    out, model_core = tmp_path / "held.csv", mover(loses=3)
    with ModelBoard(model_core) as model:
        assert run(model, "record", limits, "--seconds", "0.3", "--out", str(out), "--commanded") == 0
    assert model_core.targets == []
    _, rows = read_csv(out)
    np.testing.assert_allclose(rows[:, 7], np.arange(len(rows)) * 1e-3, atol=1e-9)
    assert "3 more found no room" in capsys.readouterr().out
    assert FORCE_MN  # the feed-forward is not what was measured, and not in the file
    assert rows.shape[1] == 10


def test_a_fault_ends_it_and_what_was_recorded_is_kept(limits, tmp_path, capsys, monkeypatch):
    out, model_core = tmp_path / "cut.csv", mover()
    kicks = []

    def read(offset: int, plain=model_core.read) -> int:
        kicks.append(offset)
        if len(kicks) == 400:
            model_core.fault(Cause.FOLLOWING)
        return plain(offset)

    monkeypatch.setattr(model_core, "read", read)
    with ModelBoard(model_core) as model:
        assert run(model, "record", limits, "--seconds", "30", "--out", str(out)) == 2
    assert "brakes engaged, faults: following" in last_line(capsys)
    assert len(read_csv(out)[1]) > 0
    assert model_core.get("control") & 1 == 0


def test_a_core_without_motion_says_so(limits, tmp_path, capsys):
    for verb, more in (("move", ("--to", "0", "0", "0")), ("record", ("--out", str(tmp_path / "x.csv")))):
        with ModelBoard(core()) as model:
            assert run(model, verb, limits, *more) == 2
        assert "neither moves nor records; build it with motion_g" in one_line(capsys).replace("\n", " ")
    assert not (tmp_path / "x.csv").exists()


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (("0", "0"), "--to 0 0: need a number for each of 3 axes"),
        (("0", "nan", "0"), "--to 0 nan 0: need a number for each of 3 axes"),
        (("0", "0.5", "0"), "axis 2 can go from -202000 to 202000 counts"),
    ],
)
def test_poses_that_cannot_be_are_refused_before_anything_moves(pose, words, limits, capsys):
    model_core = mover()
    with ModelBoard(model_core) as model:
        assert run(model, "move", limits, "--to", *pose) == 2
    assert words in last_line(capsys)
    assert (model_core.moves, model_core.get("control") & 1) == (0, 0)


def test_a_move_that_no_limit_allows_is_said(limits, capsys):
    model_core = mover(refuses=True)
    with ModelBoard(model_core) as model:
        assert run(model, "move", limits, "--to", "0.01", "0", "0", "--hold", "0") == 2
    assert "too small for the move to 10000 0 0" in last_line(capsys)
    assert model_core.get("control") & 1 == 0


def test_gains_become_registers(limits):
    """By the units of docs/guide/motion.md: P 2^-12 uA, I 2^-20 uA and tick, D over 2^filter ticks 2^-8 uA of lag."""
    found = load_motion(limits, SPHEIRO)
    tick_s = 100e-6
    assert (found.servo_filter, found.servo_speed_feed) == (2, 0)
    assert found.servo_proportional == ((40 * 2**12),) * 3
    assert found.servo_integral == tuple(round(i * tick_s * 2**20) for i in (600, 500, 400))
    assert found.servo_derivative == (round(0.8 / (tick_s * 4) * 2**8),) * 3
    assert (found.servo_limit_ua, found.following_max) == ((1_000_000,) * 3, (2000,) * 3)
    assert found.speed_max == (round(100_000 * tick_s * 2**16),) * 3
    assert found.acceleration_max == (round(1e6 * tick_s**2 * 2**24),) * 3


@pytest.mark.parametrize("value", ["true", "false"])
def test_speed_is_fed_forward_where_the_file_says_so(limits, value):
    limits.write_text(LIMITS + MOTION + f"speed_feed_forward = {value}\n")
    assert load_motion(limits, SPHEIRO).servo_speed_feed == (value == "true")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((MOTION, ""), "no table [motion]; add it with stiffness_ua_per_count"),
        (("filter = 2\n", ""), "[motion] filter: is missing; add it"),
        (("filter = 2", "filters = 2\nfilter = 2"), "[motion] filters: is no key of it"),
        (("filter = 2", "filter = 2\nspeed_feed_forward = 1"), "[motion] speed_feed_forward: need true or false"),
        (("filter = 2", "filter = 16"), "[motion] filter: need a whole number from 0 to 15"),
        (("[600, 500, 400]", "[600, 500]"), "integral_ua_per_count_s: need a number from 0 on, or 3 of them"),
        (("= 40.0", "= -1"), "stiffness_ua_per_count: need a number from 0 on"),
        (("= 40.0", "= inf"), "stiffness_ua_per_count: need a number from 0 on"),
        (("= 40.0", "= 1e9"), "proportional gain: 4096000000000 is not within"),
        (("servo_limit_ua = 1000000", "servo_limit_ua = 3e9"), "servo_limit_ua: 3e+09 is too large"),
        (("speed_counts_per_s = 100000", "speed_counts_per_s = 0"), "speed_counts_per_s: 0 is too small"),
        (("_s2 = 1000000", "_s2 = 1"), "acceleration_counts_per_s2: 1 is too small"),
    ],
)
def test_gains_that_are_none_are_refused(change, words, limits):
    limits.write_text((LIMITS + MOTION).replace(*change))
    with pytest.raises(InputError, match=re.escape(words)):
        load_motion(limits, SPHEIRO)


def test_gains_of_the_guide_are_taken(tmp_path):
    guide = (ROOT / "docs" / "guide" / "serial.md").read_text()
    path = tmp_path / "limits.toml"
    path.write_text("\n".join(re.findall(r"```toml\n(.*?)```", guide, re.DOTALL)))
    assert len(load_motion(path, SPHEIRO).servo_proportional) == load_machine(SPHEIRO).n_axes


def test_states_of_the_model_are_those_of_the_core():
    assert mover().get("status") & 7 == State.BRAKED
