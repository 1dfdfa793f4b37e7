"""The robot in the physics engine at a core behind its serial pins, in one loop: clocks, bits and frames as on a board.

40 MHz, 1 Mbaud, a step of the physics has 40 000 clocks: the driver's own Modbus client at a pseudo terminal homes the
robot, has it held and falls silent.
"""

import os
import re
import select
import shutil
import time

import numpy as np
import pytest

from gravcomp.core.folder import load_folder
from gravcomp.core.quantised import quantised
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.serial_bus import Line
from gravcomp.facts import State as Brakes
from gravcomp.robot.machine import load_machine
from gravcomp.shipped import shipped
from gravcomp.twin import network as bittrue
from gravcomp.twin.modbus import crc16, framed
from gravcomp_lab.cosim.blind import home
from gravcomp_lab.cosim.library import build
from gravcomp_lab.cosim.limits import limits_toml
from gravcomp_lab.cosim.line import SerialWorld
from runner import BUILD, ROOT

FOLDER = shipped("weights/slide")
BAUD, WATCHDOG_S, HELD_MS = 1_000_000, 0.03, 25
# Times of a board whose brakes are quick: a millisecond is a tenth of a second here.
TIMES = {"brake_us": 2_000, "watchdog_us": round(1e6 * WATCHDOG_S)}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("verilator"), reason="no Verilator; `scripts/setup.sh verilator` installs it"),
]


def limits_of(world: SerialWorld, path):
    text = limits_toml(world)
    for name, value in TIMES.items():
        text, found = re.subn(rf"(?m)^{name} = .*$", f"{name} = {value}", text)
        assert found == 1, name
    path.write_text(text)
    return load_limits(path, FOLDER)


@pytest.fixture(scope="module")
def library():
    return build(FOLDER, ROOT / "rtl", BUILD / "tb" / "line_core", baud=BAUD)


def test_a_first_frame_that_a_busy_computer_tears_apart_is_answered(library):
    """It is there before the core has run a clock, and its rest is late."""
    request = framed(bytes([1, 3, 0, 0, 0, 2]))
    world = SerialWorld(library, load_machine(FOLDER), BAUD)
    terminal = os.open(world.terminal, os.O_RDWR | os.O_NOCTTY)
    os.write(terminal, request[:3])
    with world:
        time.sleep(0.02)
        os.write(terminal, request[3:])
        answer = b""
        while len(answer) < 9:
            assert select.select([terminal], [], [], 20.0)[0], "no answer"
            answer += os.read(terminal, 9)
        os.close(terminal)
    assert (answer[:3], crc16(answer)) == (bytes([1, 3, 4]), 0)


def test_a_board_at_its_real_clock_holds_the_robot_over_its_line(library, tmp_path):
    machine = load_machine(FOLDER)
    with SerialWorld(library, machine, BAUD) as world, Board(Line(world.terminal, BAUD, timeout_s=20.0)) as board:
        board.now_s = world.now_s
        board.check_machine(FOLDER)
        limits = limits_of(world, tmp_path / "limits.toml")
        home(world, board.home(limits))
        states = board.hold(limits)
        state = next(states)
        began, here_m = world.steps, world.plant.engine.motor_positions().copy()
        while world.steps < began + HELD_MS:
            state = next(states)
        assert (state.brakes, state.fault) == (Brakes.RUN, 0)
        fixed = quantised(machine, load_folder(FOLDER).network, FOLDER)
        np.testing.assert_array_equal(state.force_mn, bittrue.core(np.array(state.position), fixed).force_mn)
        fallen_m = np.abs(world.plant.engine.motor_positions() - here_m).max()
        assert fallen_m < 0.01 * 9.81 * (1e-3 * HELD_MS) ** 2 / 2, "the core does not hold it"
        assert board.bus.repeated == 0

        world.wait(round(1.5e3 * WATCHDOG_S))  # a host that is silent
        assert (world.port.released, world.port.enabled) == (0, 0)
        states.close()
