"""gravcomp board and its driver, with pymodbus as the client, against a model of the slave behind a pseudo terminal."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from codes import ROOT
from gravcomp.cli import main
from gravcomp.driver import board as board_module
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.host import machine_settings
from gravcomp.driver.serial_bus import Line, Refused, SerialBus
from gravcomp.errors import InputError
from gravcomp.facts import Cause
from gravcomp.twin.modbus import Count, crc16
from support.model_board import ModelBoard, ModelCore, Noise

SPHEIRO = ROOT / "weights" / "spheiro"
# Of an answer of the model, which takes a few milliseconds.
TIMEOUT_S = 0.15

LIMITS = """\
index_position = [2, 2, 2]
margin_counts = 2000
speed_max_counts_per_s = 500000
current_limit_ua = 4000000
current_slew_ua = 500000
tick_us = 100
saturation_us = 10000
watchdog_us = 2000000
result_us = 1000
brake_us = 50
command_bound_ua = 100000
command_us = 5000
hold_us = 10000
"""


def core(**changes) -> ModelCore:
    """That of the Sphe.I.Ro., braked, every axis referenced."""
    expected = machine_settings(SPHEIRO)
    values = {
        "clock_hz": expected["clock_hz"],
        "weights_hash": [expected["expected_weights"], *range(7)],
        "geometry": 3 | 20 << 8 | 3 << 16 | 4 << 24,
        "encoder_geometry": 4,
        "encoder_flags": 7,
        "guards": 1,
        "position_now": [1000, 2**32 - 500, 0],
    }
    return ModelCore(**values | changes)


def line(board: ModelBoard, **changes) -> Line:
    return Line(board.port, **{"timeout_s": TIMEOUT_S} | changes)


def command(board: ModelBoard, verb: str, *arguments: str) -> int:
    return main(["board", board.port, verb, "--timeout", str(TIMEOUT_S), *arguments])


@pytest.fixture
def limits(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS)
    return path


def one_line(capsys) -> str:
    text = capsys.readouterr().err
    assert text.startswith("gravcomp board: ")
    assert text.count("\n") == 1, text
    return text


def test_crc_is_pymodbus_s():
    from pymodbus.framer import FramerRTU

    rng = np.random.default_rng(71)
    for n in (*range(12), 254):
        data = rng.bytes(n)
        assert crc16(data).to_bytes(2, "little") == FramerRTU.compute_CRC(data).to_bytes(2, "big")


def test_info_says_who_it_is_and_where_it_stands(capsys):
    with ModelBoard(core()) as board:
        assert command(board, "info", "--robot", str(SPHEIRO)) == 0
    text = capsys.readouterr().out
    assert "3 axes, 20 neurons, 4 per clock, 40 MHz" in text
    assert f"{machine_settings(SPHEIRO)['expected_weights']:08x} in the ROM" in text
    axes = [row.split() for row in text.splitlines() if row.startswith("axis")]
    assert [(row[2], row[3]) for row in axes] == [("1", "mm"), ("-0.5", "mm"), ("0", "mm")]
    assert "0 dropped" in text


def test_nothing_there_is_said(capsys, tmp_path):
    absent = tmp_path / "ttyX"
    assert main(["board", str(absent), "info"]) == 2
    assert f"{absent}: cannot be opened" in one_line(capsys)
    with ModelBoard(core(), Noise(silent=True)) as board:
        assert command(board, "info") == 2
        assert "nothing answers, 5 attempts; check cable and power, and that --baud" in one_line(capsys)
    with ModelBoard(core(), unit=9) as board:
        assert command(board, "info") == 2
        assert "nothing answers" in one_line(capsys)
        assert command(board, "info", "--unit", "9") == 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"id": 0x12345678}, "is no gravcomp core"),
        ({"version": 9 << 8}, "registers of version 0.9.0, the driver is for"),
        ({"weights_hash": [1] * 8}, "its ROM has the weights 00000001"),
        ({"clock_hz": 50_000_000}, "its clock is 50000000 Hz, that of"),
    ],
)
def test_another_core_is_refused(changes, words, capsys):
    with ModelBoard(core(**changes)) as board:
        assert command(board, "info", "--robot", str(SPHEIRO)) == 2
    assert words in one_line(capsys)


@pytest.mark.parametrize("seed", [1, 2])
def test_every_word_is_written_once_on_a_noisy_line(seed):
    """Answers lost, so that words stand that nobody acknowledged, and frames damaged both ways."""
    noise = Noise(lost_answers=0.1, damaged_answers=0.1, damaged_requests=0.1, seed=seed)
    image = np.random.default_rng(seed).bytes(4 * 60)
    with ModelBoard(core(), noise) as model, Board(line(model, timeout_s=0.03, attempts=12)) as board:
        board.load(image)
        assert model.core.image == np.frombuffer(image, "<u4").tolist()
        assert board.bus.repeated > 10
        assert board.bus.count(Count.WRITTEN) == model.slave.counts[Count.WRITTEN]


def test_noise_without_end_is_said(capsys):
    with ModelBoard(core(), Noise(damaged_answers=1.0)) as board:
        assert command(board, "info") == 2
    assert "damaged answers, 5 attempts; is it --baud and --parity" in one_line(capsys)


def test_noise_that_was_overcome_is_counted(capsys):
    with ModelBoard(core(), Noise(lost_answers=0.1, seed=3)) as board:
        assert command(board, "info") == 0
    sent_again = capsys.readouterr().err
    assert "frames sent again" in sent_again


def test_refused_word_ends_a_run_and_those_before_it_stand():
    with ModelBoard(core()) as model, SerialBus(line(model)) as bus:
        names = ("command_clocks", "hold_clocks", "brake_test_clocks")  # then there is none
        low = model.core.map[names[0]].address
        with pytest.raises(Refused, match="the core refused the access") as refused:
            bus.write_run(low, [1, 2, 3, 4])
        assert refused.value.code == 4
        assert [model.core.get(name) for name in names] == [1, 2, 3]
        bus.write(low, 7)
        assert model.core.get(names[0]) == 7
        model.noise.lost_answers = 1.0
        with pytest.raises(InputError, match="no answer any more"):
            bus.read(low)


def test_write_after_an_interrupted_one_is_not_taken_for_it():
    """Ctrl-C between a word and its answer: the port has counted a word that the driver has not."""
    with ModelBoard(core()) as model, SerialBus(line(model)) as bus:
        bus.write(address := model.core.map["command_clocks"].address, 1)
        write = bus._client.write_registers

        def interrupted(*arguments, **options):
            write(*arguments, **options)
            raise KeyboardInterrupt

        bus._client.write_registers = interrupted
        with pytest.raises(KeyboardInterrupt):
            bus.write(address, 2)
        bus._client.write_registers = write
        # Of the frames that come now, the first is to count, the second to write: it is lost.
        strikes = iter([False] * 3 + [True])
        model.noise.strikes = lambda _: next(strikes, False)
        bus.write(address, 3)
        assert model.core.get("command_clocks") == 3
        assert bus.repeated == 1


def test_hold_ends_braked(capsys, limits):
    with ModelBoard(core()) as board:
        held = ("--robot", str(SPHEIRO), "--limits", str(limits))
        assert command(board, "hold", *held, "--seconds", "0.3") == 0
        assert "run, result" in capsys.readouterr().out
        assert board.core.get("control") & 1 == 0
        assert board.core.kicks > 2
        assert board.core.get("current_limit_ua") == 4_000_000


def test_limits_of_each_axis_are_one_number_or_one_each(limits):
    limits.write_text(LIMITS.replace("current_limit_ua = 4000000", "current_limit_ua = [1, 2, 3]"))
    settings = load_limits(limits, SPHEIRO)
    assert settings.current_limit_ua == (1, 2, 3)
    assert settings.current_slew_ua == (500_000,) * 3
    assert settings.index_position == (2, 2, 2)


def test_a_core_of_other_axes_is_refused(capsys):
    with ModelBoard(core(geometry=6 | 20 << 8 | 6 << 16 | 4 << 24, encoder_flags=63, position_now=[0] * 6)) as board:
        assert command(board, "info", "--robot", str(SPHEIRO)) == 2
        assert "its axes are 6, those of" in one_line(capsys)


def test_hold_is_refused_without_reference(capsys, limits):
    with ModelBoard(core(encoder_flags=5)) as board:
        assert command(board, "hold", "--robot", str(SPHEIRO), "--limits", str(limits)) == 2
        assert "axes 2 have not passed their index; start `home` first" in one_line(capsys)
        assert board.core.get("control") & 1 == 0


def test_fault_ends_hold_with_its_name(limits):
    with ModelBoard(core()) as model, Board(line(model)) as board:
        held = board.hold(load_limits(limits, SPHEIRO))
        next(held)
        model.core.fault(Cause.ESTOP)
        with pytest.raises(InputError, match="brakes engaged, faults: estop; release the emergency stop"):
            next(held)
        assert model.core.get("control") & 1 == 0


@pytest.mark.parametrize("cause", [Cause.SATURATION, Cause.HOLD])
@pytest.mark.parametrize(
    ("clamped", "said"),
    [
        (0b101, "axes 1, 3 stand outside of the range the core was trained for; move them into it"),
        (0, "current_limit_ua"),
    ],
)
def test_hold_tells_axes_out_of_their_trained_range_by_number(limits, cause, clamped, said):
    """HOLDING with a clamped count ends by the first of two time-outs; either alone would not say why."""
    with ModelBoard(core()) as model, Board(line(model)) as board:
        held = board.hold(load_limits(limits, SPHEIRO))
        next(held)
        model.core.put("result_flags", clamped)
        model.core.fault(cause)
        with pytest.raises(InputError, match=f"brakes engaged, faults: {cause.name.lower()}; .*{said}"):
            next(held)


def test_cut_line_ends_hold(limits):
    with ModelBoard(core()) as model, Board(line(model, timeout_s=0.05, attempts=2)) as board:
        held = board.hold(load_limits(limits, SPHEIRO))
        next(held)
        model.noise.silent = True
        with pytest.raises(InputError, match="no answer any more, 2 attempts; check cable and power"):
            next(held)


def test_watchdog_shorter_than_the_line_is_refused(limits, capsys):
    limits.write_text(LIMITS.replace("watchdog_us = 2000000", "watchdog_us = 2000"))
    with ModelBoard(core()) as board:
        assert command(board, "hold", "--robot", str(SPHEIRO), "--limits", str(limits)) == 2
        assert "watchdog_us = 2000, but the 10 exchanges from kick to kick take" in one_line(capsys)


def test_home_tells_each_axis(limits, capsys):
    with ModelBoard(core(encoder_flags=0)) as model, Board(line(model)) as board:
        states = board.home(load_limits(limits, SPHEIRO))
        assert next(states).referenced == 0
        assert model.core.get("control") >> 4 & 7 == 7
        model.core.put("encoder_flags", 7)
        assert [state.referenced for state in states] == [7]


def test_load_is_refused_whole(capsys):
    model_core = core()
    model_core.accepts = False
    with ModelBoard(model_core) as model, Board(line(model)) as board:
        with pytest.raises(InputError, match="the core refuses the image, which is of another size"):
            board.load(bytes(16))
        assert not model.core.bad, "the refusal is a fault until it is forgotten"
        model.core.is_loadable = False
        with pytest.raises(InputError, match="built without banks"):
            board.load(bytes(16))


def test_selftest_tells_what_is_wrong(capsys):
    with ModelBoard(core()) as board:
        assert command(board, "selftest") == 0
        text = capsys.readouterr().out
        assert text.count("ok    ") == len(text.splitlines()) >= 8
        board.core.put("guards", 0)
        board.core.put("clock_hz", 30_000_000)  # the model's results come slower then: the driver read it before
        assert command(board, "selftest") == 2
        printed = capsys.readouterr()
        assert "FAILED clock of the core runs" in printed.out
        assert "failed: clock of the core runs" in printed.err


def test_selftest_finds_a_core_of_another_clock():
    with ModelBoard(core()) as model, Board(line(model)) as board:
        model.core.put("clock_hz", 30_000_000)
        wrong = [check.name for check in board.selftest() if not check.is_right]
        assert wrong == ["results come with the tick"]


def test_limits_of_the_guide_can_be_held(tmp_path):
    guide = (ROOT / "docs" / "guide" / "serial.md").read_text()
    path = tmp_path / "limits.toml"
    path.write_text(re.search(r"```toml\n(.*?)```", guide, re.DOTALL)[1])
    with ModelBoard(core()) as model, Board(line(model)) as board:
        assert board.host.complaint(board.identity, load_limits(path, SPHEIRO)) is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("info", "--baud", "5"), "--baud 5: need 1200 to 3000000"),
        (("info", "--unit", "0"), "--unit 0: need 1 to 247"),
        (("info", "--timeout", "0"), "--timeout 0: need more than 0"),
        (("info", "--timeout", "nan"), "--timeout nan: need more than 0"),
        (("watch", "--seconds", "-1"), "--seconds -1: need more than 0"),
        (("move", "--robot", "x", "--limits", "y", "--to", "0", "--hold", "-1"), "--hold -1: need 0 or more"),
        (("info", "--parity", "mark"), "invalid choice: 'mark'"),
        (("fly",), "invalid choice: 'fly'"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments, words, capsys):
    try:
        status = main(["board", "/dev/null", *arguments])
    except SystemExit as stop:
        status = stop.code
    assert status == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("brake_us = 50\n", ""), "brake_us is missing; add it"),
        (("brake_us = 50", "brake_ms = 50"), "brake_ms: not a limit; those are"),
        (("brake_us = 50", "brake_us = -1"), "brake_us: need a whole number from 0 to 4294967295"),
        (("brake_us = 50", "brake_us = true"), "brake_us: need a whole number"),
        (("tick_us = 100", "tick_us = [100, 100, 100]"), "tick_us: need a whole number"),
        (("current_slew_ua = 500000", "current_slew_ua = [1, 2]"), "current_slew_ua: need 3 whole numbers in brackets"),
        (("[2, 2, 2]", "[2, 2]"), "index_position: need 3 whole numbers in brackets"),
        (("brake_us = 50", "brake_us ="), "cannot be read"),
    ],
)
def test_limits_are_read_key_by_key(change, words, limits):
    limits.write_text(LIMITS.replace(*change))
    with pytest.raises(InputError, match=r"limits\.toml") as refused:
        load_limits(limits, SPHEIRO)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_watch_ends_at_ctrl_c():
    import signal

    with ModelBoard(core()) as board:
        watching = subprocess.Popen(
            [sys.executable, "-m", "gravcomp", "board", board.port, "watch"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT / "sim")},
        )  # fmt: skip
        assert watching.stdout.readline().startswith("state braked")
        watching.send_signal(signal.SIGINT)
        _, error = watching.communicate(timeout=10)
        assert watching.returncode == 0, error
        assert "Traceback" not in error


def test_exchanges_between_kicks_are_no_more_than_the_driver_says(limits):
    """From kick to kick of hold, counted on the line."""
    with ModelBoard(core()) as model, Board(line(model)) as board:
        held = board.hold(load_limits(limits, SPHEIRO))
        next(held)
        sent, kicks = board.bus.sent, model.core.kicks
        next(held)
        assert model.core.kicks == kicks + 1
        assert board.bus.sent - sent <= board_module.EXCHANGES_PER_KICK
        held.close()
