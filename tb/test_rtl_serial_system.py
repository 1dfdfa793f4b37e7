"""gc_serial_system through its pins: frames, and the driver with its Modbus client behind a pseudo terminal."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotbext.uart import UartSource

from codes import fixed_compensation, fixed_network, weights_under_test
from gravcomp.driver.board import Board as Driver
from gravcomp.driver.host import Result, Settings, machine_settings
from gravcomp.driver.registers import read_registers
from gravcomp.driver.serial_bus import Line
from gravcomp.facts import State as Brakes
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp.twin.modbus import Count, ModbusSlave, framed
from runner import BUILD, simulate
from support.serial_board import BAUD, BUS_HZ, INDEX, SerialBoard

REGISTERS = read_registers()
LIMIT_UA = 4_000_000
# At the ROM's 40 MHz, of which the simulated clock makes a tenth.
WATCHDOG_US = 400


def request(function: int, first: int, quantity: int, data: bytes = b"") -> bytes:
    tail = bytes([len(data)]) + data if data else b""
    return framed(bytes([1, function]) + first.to_bytes(2, "big") + quantity.to_bytes(2, "big") + tail)


class Known:
    """The registers that the frames of this test meet, for the twin."""

    def __init__(self):
        self.words = {REGISTERS["id"].address: REGISTERS["id"].reset, REGISTERS["version"].address:
                      REGISTERS["version"].reset}  # fmt: skip

    def read(self, offset: int) -> int:
        return self.words[offset]

    def write(self, offset: int, word: int) -> None:
        self.words[offset] = word


@cocotb.test()
async def frames(dut):
    """Identity, a run of words there and back, a refused one, a wrong CRC, a wrong baud, each right after an answer."""
    board, twin = SerialBoard(dut), ModbusSlave(Known())
    await board.start()
    low = REGISTERS["window_low"].address // 2
    data = np.random.default_rng(81).bytes(12)
    for frame in (request(3, 0, 4), request(16, low, 6, data), request(4, low, 6)):
        assert await board.exchange(frame) == twin.answer(frame)
    assert await board.exchange(request(3, 0xFFC // 2, 2)) == framed(bytes([1, 0x83, 4]))
    assert await board.exchange(request(16, 0, 2, data[:4])) == framed(bytes([1, 0x90, 4]))
    good = request(3, 0, 2)
    assert await board.exchange(good[:4] + bytes([good[4] ^ 8]) + good[5:]) is None
    slow = UartSource(dut.pin_rx, baud=BAUD // 2, bits=8)
    slow.log.setLevel("WARNING")
    await slow.write(good)
    await slow.wait()
    await board.bits(2 * 36)
    assert await board.exchange(good) == twin.answer(good)
    counts = await board.exchange(request(3, Count.ANSWERED.offset // 2, 8))
    answered, dropped, written, exceptions = (int.from_bytes(counts[k : k + 4], "big") for k in range(3, 19, 4))
    assert (answered, written, exceptions) == (6, 3, 2)
    assert dropped >= 2


def settings() -> Settings:
    return Settings(
        **machine_settings(weights_under_test()), index_position=(INDEX,) * 3, index_period=(0,) * 3,
        margin_counts=(2000,) * 3, speed_max_counts_per_s=(5_000_000,) * 3, current_limit_ua=(LIMIT_UA,) * 3,
        current_slew_ua=(LIMIT_UA,) * 3, command_bound_ua=(10_000,) * 3, tick_us=100, saturation_us=10**6,
        watchdog_us=4 * 10**6, result_us=10_000, brake_us=5, command_us=10_000, hold_us=10_000,
    )  # fmt: skip


def client(port: str) -> dict:
    """What a user's program does: find the core, home, release the brakes, look, and then die: nothing is stopped."""
    with Driver(Line(port, BAUD, timeout_s=300.0, attempts=1)) as driver:
        driver.check_machine(weights_under_test())
        *_, homed = driver.home(settings())
        # In this simulation a second of the line takes minutes: hold would find the watchdog too short.
        driver.host.configure(driver.identity, replace(settings(), watchdog_us=WATCHDOG_US))
        result = driver.host.release(20)
        driver.host.kick()
        state = driver.host.read()
        return {"homed": homed.referenced, "result": result, **vars(state), "counts": driver.counts()}


@cocotb.test()
async def driver(dut):
    board = SerialBoard(dut)
    await board.start()
    code = f"import json, test_rtl_serial_system as t; print(json.dumps(t.client({board.serve()!r})))"
    running = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ, "COCOTB_TEST_MODULES": ""}
    )
    while running.poll() is None:
        for target in (INDEX - 8, INDEX + 8, INDEX):  # by hand, over and over until the driver has seen it
            while set(board.position) != {target} and not board.is_released():
                board.position = [p + (p < target) - (p > target) for p in board.position]
                board.drive()
                await board.clocks(10)
            await board.clocks(20)
    assert running.returncode == 0
    found = json.loads(running.stdout.read())
    Path(os.environ["FOUND"]).write_text(json.dumps(found))
    assert board.is_released(), "the watchdog has time left"
    dut._log.info("line silent")
    for _ in range(40 * WATCHDOG_US + 2000):
        await board.clocks(1)
        if not board.is_released():
            break
    assert not board.is_released()
    assert int(dut.brake_engage.value) == 7


def simulate_serial(test: str, **environment: str) -> None:
    simulate(
        "gc_serial_system",
        "test_rtl_serial_system",
        tests=rf"\.{test}$",
        label=test,
        generics={"bus_clock_hz_g": BUS_HZ, "baud_g": BAUD, "gap_us_g": 0, "lanes_g": 1, "filter_samples_g": 2},
        environment=environment,
    )


def test_frames_through_the_pins_of_the_system():
    simulate_serial("frames")


@pytest.mark.slow
def test_driver_homes_and_releases_over_the_line_and_a_silent_line_engages_the_brakes():
    path = BUILD / "serial" / "found.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    simulate_serial("driver", FOUND=str(path))
    found = json.loads(path.read_text())
    assert (found["homed"], found["result"], found["brakes"]) == (7, Result.OK, Brakes.RUN)
    fixed, position = fixed_network(), np.array(found["position"])
    network_mn = bittrue.core(position, fixed).force_mn
    force_mn, _ = compensator(network_mn, position, np.array(found["speed_period"]), fixed_compensation())
    np.testing.assert_array_equal(found["force_mn"], force_mn)
    np.testing.assert_array_equal(found["current_ua"], bittrue.current_scaler(force_mn, fixed))
    assert found["counts"]["dropped"] == found["counts"]["exceptions"] == 0
