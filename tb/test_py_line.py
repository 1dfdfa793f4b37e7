"""The Modbus master in C on the twin of gc_modbus: the driver's answers, words written once, what went wrong said."""

import subprocess

import numpy as np
import pytest

from c_line import CLineBus, LineResult, compile_line
from codes import ROOT
from gravcomp.driver.host import Host, Result
from gravcomp.twin.modbus import Count, ModbusSlave
from support.model_board import ModelCore, Noise
from test_py_board import core


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compile_line(tmp_path_factory.mktemp("line"))


def behind(slave: ModbusSlave, noise: Noise):
    """What comes back for a frame."""

    def answer(frame: bytes) -> bytes:
        came = slave.answer(noise.damage(frame) if noise.strikes(noise.damaged_requests) else frame)
        if came is None or noise.silent or noise.strikes(noise.lost_answers):
            return b""
        return noise.damage(came) if noise.strikes(noise.damaged_answers) else came

    return answer


def bus(library, model: ModelCore, noise: Noise | None = None, **line) -> tuple[CLineBus, ModbusSlave]:
    slave = ModbusSlave(model)
    return CLineBus(library, behind(slave, noise or Noise()), **line), slave


def test_driver_finds_the_core_over_the_line(library):
    line, _ = bus(library, core())
    assert line.opened == LineResult.OK
    result, identity = Host(line).open()
    assert (result, identity) == Host(core()).open()
    assert result == Result.OK
    assert line.line.first == LineResult.OK


@pytest.mark.parametrize("seed", range(5))
def test_every_word_is_written_once_on_a_noisy_line(library, seed):
    """Answers lost, cut and damaged, requests damaged: as in the driver in Python."""
    noise = Noise(lost_answers=0.15, damaged_answers=0.15, damaged_requests=0.15, seed=seed)
    model = core()
    line, slave = bus(library, model, noise, attempts=20)
    image = np.random.default_rng(seed).bytes(4 * 300)
    host = Host(line)
    assert host.load(image, host.crc32(image), 10) == Result.OK
    assert model.image == np.frombuffer(image, "<u4").tolist()
    assert line.line.repeated > 100
    assert line.line.first == LineResult.OK
    assert line.line.written == slave.counts[Count.WRITTEN]


def test_runs_are_whole_words_and_stop_where_they_are_refused(library):
    model = core()
    line, slave = bus(library, model)
    low = model.map["command_clocks"].address
    assert line.write_run(low, [1, 2**32 - 2, 3]) == LineResult.OK
    assert line.read_run(low, 3) == [1, 2**32 - 2, 3]
    assert line.write_run(low, [4, 5, 6, 7]) == LineResult.REFUSED, "behind the third there is no register"
    assert line.line.exception == 4
    assert line.read_run(low, 3) == [4, 5, 6]
    assert line.line.written == slave.counts[Count.WRITTEN] == 6
    line.read(0xFFC)
    assert line.line.first == LineResult.REFUSED


def test_refusal_whose_answer_is_lost_is_still_one(library):
    model, noise = core(), Noise()
    slave = ModbusSlave(model)
    heard = behind(slave, noise)
    lost = []

    def answer(frame: bytes) -> bytes:
        came = heard(frame)
        if frame[1] == 16 and not lost:
            lost.append(frame)
            return b""
        return came

    line = CLineBus(library, answer)
    assert line.write_run(model.map["command_clocks"].address, [1, 2, 3, 4]) == LineResult.REFUSED
    assert len(lost) == 1
    assert slave.counts[Count.WRITTEN] == 3, "it is not sent again"


def test_write_after_one_without_an_end_is_not_taken_for_it(library):
    """The line goes after a word was written, and comes back: the port has counted a word that the driver has not."""
    model = core()
    slave, passes, written = ModbusSlave(model), [True], []

    def answer(frame: bytes) -> bytes:
        if frame[1] == 16:
            written.append(frame)
            if len(written) == 3:  # the one after: lost on its way
                return b""
        came = slave.answer(frame) or b""
        return came if passes[0] else b""

    line, address = CLineBus(library, answer, attempts=2), model.map["command_clocks"].address
    assert line.write_run(address, [1]) == LineResult.OK
    passes[0] = False
    assert line.write_run(address, [2]) == LineResult.SILENT
    assert len(written) == 2, "what may stand is not sent again"
    passes[0] = True
    assert line.write_run(address, [3]) == LineResult.OK
    assert model.get("command_clocks") == 3


CPP = """
#include "gravcomp_modbus.h"

static void send(void *, const uint8_t *, uint32_t) {}
static uint32_t receive(void *, uint8_t *, uint32_t) { return 0; }

int main()
{
    gravcomp_line line = {send, receive, nullptr, 1, 2, GRAVCOMP_LINE_OK, 0, 0, 0, false};
    gravcomp_bus bus;

    return gravcomp_line_open(&line, &bus) == GRAVCOMP_LINE_SILENT && line.repeated == 1 ? 0 : 1;
}
"""


def test_line_links_into_a_program_in_cpp(tmp_path):
    (tmp_path / "main.cpp").write_text(CPP)
    host = ROOT / "host"
    subprocess.run(
        ["cc", "-std=c99", f"-I{host}", "-c", host / "gravcomp_modbus.c", "-o", tmp_path / "line.o"], check=True
    )
    strict = ["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{host}"]
    subprocess.run(["c++", *strict, tmp_path / "main.cpp", tmp_path / "line.o", "-o", tmp_path / "main"], check=True)
    subprocess.run([tmp_path / "main"], check=True)


@pytest.mark.parametrize(
    ("noise", "result"),
    [(Noise(silent=True), LineResult.SILENT), (Noise(damaged_answers=1.0), LineResult.DAMAGED)],
)
def test_line_that_is_no_good_is_told(library, noise, result):
    line, _ = bus(library, core(), noise)
    assert line.opened == result
    assert line.line.repeated == 4
    assert line.read(0) == 0
    assert line.line.first == result
