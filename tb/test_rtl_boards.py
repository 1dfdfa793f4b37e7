"""A board's top through its pins, with the desk's axes: over the line in, encoders by hand, brakes and PWM out."""

import json
import os
import subprocess
import sys
from pathlib import Path

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer
from cocotbext.uart import UartSink, UartSource

from gravcomp.driver.host import Result
from gravcomp.facts import State as Brakes
from gravcomp_lab.boards.board import boards
from runner import BUILD, ROOT, simulate
from support.serial_board import SerialBoard
from test_rtl_serial_system import WATCHDOG_US

ULX3S = boards(ROOT / "boards")["ulx3s-85f"]
BAUD = 3_000_000
# The core's clock is that of the oscillator over eight (gc_pll), and counts its times as if it were 40 MHz.
DIVIDED = 8
SLOWER = 40 * DIVIDED / 25
PWM_CLOCKS = 2000 * DIVIDED  # of the oscillator


class Pins(SerialBoard):
    """A board whose pins are those of the ULX3S."""

    async def start(self) -> None:
        dut = self.dut
        Clock(dut.clk_25mhz, 40, "ns").start()
        dut.btn_pwr_n.value = 0
        self.source = UartSource(dut.ftdi_txd, baud=BAUD, bits=8)
        self.sink = UartSink(dut.ftdi_rxd, baud=BAUD, bits=8)
        for end in (self.source, self.sink):
            end.log.setLevel("WARNING")
        await Timer(2, "us")
        dut.btn_pwr_n.value = 1
        await Timer(100, "us")


async def duties(dut) -> list[float]:
    """Duty of the PWM of each axis, up less down, over a period."""
    high = [0] * 3
    for _ in range(PWM_CLOCKS):
        await FallingEdge(dut.clk_25mhz)
        up, down = int(dut.pwm_up.value), int(dut.pwm_down.value)
        high = [n + (up >> k & 1) - (down >> k & 1) for k, n in enumerate(high)]
    return [n / PWM_CLOCKS for n in high]


@cocotb.test()
async def desk(dut):
    board = Pins(dut)
    await board.start()
    assert int(dut.brake_hold.value) == 7
    assert int(dut.brake_free.value) == 0
    code = f"import json, test_rtl_serial_system as t; print(json.dumps(t.client({board.serve()!r})))"
    running = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ, "COCOTB_TEST_MODULES": ""}
    )
    while running.poll() is None:
        await Timer(20, "us")
    assert running.returncode == 0
    found = json.loads(running.stdout.read())
    assert int(dut.brake_free.value) == 7
    assert int(dut.brake_hold.value) == 0
    found["duty"] = await duties(dut)
    Path(os.environ["FOUND"]).write_text(json.dumps(found))
    await Timer(round(SLOWER * (WATCHDOG_US + 20)), "us")
    assert int(dut.brake_free.value) == 0, "nobody kicks the watchdog"
    assert int(dut.brake_hold.value) == 7


@pytest.mark.slow
def test_board_homes_and_holds_over_its_line():
    path = BUILD / "boards" / "found.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    simulate(
        "ulx3s",
        "test_rtl_boards",
        extra_sources=ULX3S.sources,
        generics={"baud_g": BAUD, "gap_us_g": 0, "desk_step_g": 1, "selftest_g": "true", "loadable_g": "false"},
        environment={"FOUND": str(path)},
    )
    found = json.loads(path.read_text())
    assert (found["homed"], found["result"], found["brakes"]) == (7, Result.OK, Brakes.RUN)
    assert found["duty"] == pytest.approx([current / 5_000_000 for current in found["current_ua"]], abs=0.02)
