"""The drivers in C and Python against the simulated core: the same calls give the same answers, write for write."""

import os
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.task import bridge, resume

from c_host import CHost, compile_host
from codes import ROOT, fixed_network, pack
from gravcomp.cli import main
from gravcomp.core.formats import COUNT_BITS
from gravcomp.driver.host import (
    WRONG_AXES,
    WRONG_CLOCK,
    Brakes,
    Event,
    Host,
    Identity,
    Result,
    Settings,
    State,
)
from gravcomp.driver.registers import read_registers
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp_lab.benches.axi import SimulatedBus
from gravcomp_lab.benches.system import System
from loading import image_of, other_weights
from machines import SHIPPED
from runner import BENCHES, BUILD, simulate
from support.host import INDEX, SETTINGS

POSES = [(2042, -3001, 4002), (1990, -3042, 3961), (2002, -3002, 4002)]
POLLS = 300
ESTOP = 1
HOMING_CLOCKS = 100_000
SHORT_IMAGE = bytes(range(256)) * 2
SPEED_TIMEOUT = 100  # clocks to standstill
STILL = 2**31 - 1  # speed_period then


class Robot:
    """What the world does to the core, blocking."""

    def __init__(self, system: System):
        self.system = system
        self.walk_to = resume(system.walk_to)
        self.wait = resume(system.clocks)
        self.load = resume(self._load)

    async def _load(self) -> None:
        await self.system.put_before(INDEX)
        await self.system.clocks(60)

    def stop(self, is_pressed: bool) -> None:
        """Press the emergency stop, or let it go."""
        self.system.dut.estop_n.value = int(not is_pressed)
        self.wait(40)


def session(host: Host | CHost, robot: Robot) -> list:
    """All functions of the driver; returns what they returned."""
    answers = [host.open(), host.core_runs(), host.brakes_fed()]
    identity = answers[0][1]
    answers.append(host.configure(identity, SETTINGS))
    answers.append(host.release(3))  # not homed: refused
    answers.append(host.home(7))
    robot.load()
    robot.walk_to(INDEX)
    host.clear_encoders()
    host.interrupts()
    host.interrupt_on(Event.RESULT)
    for number, pose in enumerate(POSES):
        robot.walk_to(pose)
        robot.wait(2 * SPEED_TIMEOUT)
        host.start()
        answers += [host.wait(number, POLLS), host.interrupts(), host.read()]
    answers += [host.wait(len(POSES), 2), host.tick(True), host.release(POLLS), settled(host)]
    robot.stop(True)
    answers += [unnumbered(host.read()), host.release(3), host.interrupts() & Event.FAULT]
    robot.stop(False)
    host.kick()
    host.clear_faults(ESTOP)
    robot.wait(40)
    answers.append(unnumbered(host.read()))
    answers += [host.release(POLLS), settled(host), host.stop()]
    robot.wait(400)
    answers += [unnumbered(host.read()), host.tick(False)]
    answers += [host.load(SHORT_IMAGE, 0, POLLS), host.bank_crc(), host.use_rom(POLLS)]
    return answers


def settled(host: Host | CHost) -> State:
    """The state once no command is under way."""
    for _ in range(10):
        host.kick()
        state = host.read()
    return unnumbered(state)


def unnumbered(state: State) -> State:
    """Without what depends on when the host reads."""
    return replace(state, result_number=0, missed_ticks=0, busy=0)


@cocotb.test()
async def same_answers(dut):
    answers, written = {}, {}
    for name in ("C", "Python"):
        system = System(dut)
        await system.start(axi_mhz=33.3)
        bus, robot = SimulatedBus(system.registers), Robot(system)
        host = CHost(Path(os.environ["LIBRARY"]), bus) if name == "C" else Host(bus)
        answers[name] = await bridge(session)(host, robot)
        written[name] = bus.written
    for c, python in zip(answers["C"], answers["Python"], strict=True):
        assert c == python
    assert written["C"][:30] == written["Python"][:30]
    check(answers["C"])


def check(answers: list) -> None:
    """The answers are the right ones, not only the same ones."""
    results = [answer for answer in answers if isinstance(answer, Result)]
    ok, fault = Result.OK, Result.FAULT
    assert results == [ok, fault, ok, ok, ok, ok, Result.TIMEOUT, ok, ok, fault, ok, ok, ok, Result.REFUSED, ok]
    states = [answer for answer in answers if isinstance(answer, State)]
    fixed = fixed_network()
    for state, pose in zip(states[:3], POSES, strict=True):
        force_mn = bittrue.core(np.array(pose), fixed).force_mn
        assert (state.position, state.position_now, state.referenced) == (pose, pose, 7)
        np.testing.assert_array_equal(state.force_mn, force_mn)
        np.testing.assert_array_equal(state.current_ua, bittrue.current_scaler(force_mn, fixed))
    released, stopped, cleared, again, braked = states[3:]
    assert (released.brakes, released.released, released.run) == (Brakes.RUN, 7, 1)
    assert released.command_ua == released.current_ua
    assert released.limited == sum(
        (asked > limit) << axis
        for axis, (asked, limit) in enumerate(zip(released.current_ua, SETTINGS.current_limit_ua, strict=True))
    )
    assert (stopped.brakes, stopped.released, stopped.fault & 1, stopped.first_cause) == (Brakes.FAULTED, 0, 1, 1)
    assert stopped.command_ua == (0, 0, 0)
    assert stopped.first_position == POSES[-1]
    assert (cleared.brakes, cleared.fault, cleared.first_cause) == (Brakes.BRAKED, 0, 0)
    assert again == replace(released, first_cause=again.first_cause, first_position=again.first_position)
    assert (braked.brakes, braked.released, braked.command_ua) == (Brakes.BRAKED, 0, (0, 0, 0))


def home_twice(host: Host | CHost, robot: Robot) -> list[int]:
    """Axes referenced after homing, and after homing has been armed again."""
    _, identity = host.open()
    host.configure(identity, SETTINGS)
    host.home(7)
    robot.load()
    robot.walk_to(INDEX)
    robot.walk_to(INDEX + 8)
    once = host.read().referenced
    host.home(7)
    return [once, host.read().referenced]


@cocotb.test()
async def slow_core(dut):
    """The host is much faster than the core: arming homing again is an edge that the core must not miss."""
    for name in ("C", "Python"):
        system = System(dut)
        await system.start(axi_mhz=100, core_mhz=5)
        bus = SimulatedBus(system.registers)
        host = CHost(Path(os.environ["LIBRARY"]), bus) if name == "C" else Host(bus)
        assert await bridge(home_twice)(host, Robot(system)) == [7, 0], name


@cocotb.test()
async def example(dut):
    system = System(dut)
    await system.start(axi_mhz=100)
    host = CHost(Path(os.environ["LIBRARY"]), SimulatedBus(system.registers))

    image = Path(os.environ["IMAGE"]).read_bytes()
    dut.index_count.value = pack([2, 2, 2], COUNT_BITS)  # two counts before the end of the walk

    async def move_over_the_index():
        for _ in range(HOMING_CLOCKS // 10):
            await system.clocks(10)
            dut.settings_bits.value = dut.i_system.core_settings_word.value
            if dut.settings_home.value == 7:
                break
        else:
            raise AssertionError(f"not homing after {HOMING_CLOCKS} clocks")
        await system.walk_to(np.array([-8, -8, -8]))
        await system.walk_to(np.array([8, 8, 8]))
        await system.walk_to(np.array([4, 4, 4]))

    cocotb.start_soon(move_over_the_index())
    assert await bridge(host.run_example)(image, 2) == 0


def simulate_host(cocotb_test: str, **environment: str) -> None:
    library = compile_host(BUILD / "host" / cocotb_test, "-DTICK_US=20")
    simulate(
        "gc_system_bench",
        "test_rtl_host",
        tests=rf"\.{cocotb_test}(/|$)",
        label=cocotb_test,
        generics={"lanes_g": 1, "speed_timeout_g": SPEED_TIMEOUT},
        environment={"LIBRARY": str(library), **environment},
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_system_bench")),
    )


@pytest.mark.slow
def test_host_in_c_and_its_python_twin_give_the_same_answers():
    simulate_host("same_answers")


def test_host_waits_for_a_slow_core():
    simulate_host("slow_core")


@pytest.mark.slow
def test_host_example_loads_homes_releases_and_prints_forces():
    folder = other_weights(BUILD / "host" / "weights")
    image, path = image_of(folder), folder / "image.bin"
    assert main(["image", "--weights", str(folder), "--rom", str(SHIPPED), "--out", str(path)]) == 0
    simulate_host("example", IMAGE=str(path))
    log = next(BUILD.glob("tb/test_rtl_host-example-lanes_g1-*/run.log")).read_text()
    assert f"image of {len(image.words)} words, CRC-32 {image.crc32:08x}" in log
    lines = [line for line in log.splitlines() if " A" in line and " q1 " in line]
    assert lines
    position = np.array([2] * 3)
    network_mn = bittrue.core(position, image.network).force_mn
    force_n = compensator(network_mn, position, np.array([STILL] * 3), image.compensation)[0] / 1e3
    for line in lines:
        assert [float(text) for text in re.findall(r"q\d +([-.\d]+) ", line)] == [2] * 3
        np.testing.assert_allclose(
            [float(text) for text in re.findall(r"([-.\d]+) +[-.\d]+ A", line)], force_n, atol=1e-9
        )
    assert len(lines) == 2


TOO_SHORT = "hold_us: shorter than the slew from 0 to current_limit_ua, brake_us and the test of the brakes"
UNUSABLE = [
    ({"axes": 6}, WRONG_AXES),
    ({"clock_hz": 100_000_000}, WRONG_CLOCK),
    ({"current_limit_ua": 0}, "current_limit_ua: 0 carries no load"),
    ({"current_slew_ua": 0}, "current_slew_ua: 0 never reaches current_limit_ua"),
    ({"index_period": (4, 4, 2)}, "index_period: not a multiple of 4"),
    ({"hold_us": 15}, TOO_SHORT),
    ({"current_slew_ua": 46_874}, TOO_SHORT),
    ({"brake_us": 90}, TOO_SHORT),
    ({"brake_test_us": 8}, TOO_SHORT),
    *(({name: 2**31}, f"{name}: above 2147483647") for name in ("current_limit_ua", "current_slew_ua",
                                                                 "command_bound_ua")),
]  # fmt: skip
USABLE = [
    {},
    {"hold_us": 16},
    {"brake_test_us": 6},
    {"current_slew_ua": 46_875},
    {"current_slew_ua": 2**31 - 1, "current_limit_ua": 2**31 - 1},
]


def changed_on_an_axis(changes: dict) -> Settings:
    """The settings with other values; of those that each axis has, on the last axis."""
    usual = {name: getattr(SETTINGS, name) for name in changes}
    return replace(SETTINGS, **{
        name: (*usual[name][:-1], value) if isinstance(usual[name], tuple) and isinstance(value, int) else value
        for name, value in changes.items()
    })  # fmt: skip


def test_host_refuses_settings_that_never_release_the_brakes(tmp_path):
    """In C and in Python, in the same words, and before anything is written."""
    library = compile_host(tmp_path)
    identity = Identity(3, 20, 4, False, 40_000_000, 4, (0,) * 8, (0,) * 8, (0,) * 3, (0,) * 3)
    for changes, line in [*UNUSABLE, *((changes, None) for changes in USABLE)]:
        for name in ("C", "Python"):
            bus = FakeBus()
            host = CHost(library, bus) if name == "C" else Host(bus)
            settings = changed_on_an_axis(changes)
            assert host.complaint(identity, settings) == line, (name, changes)
            assert (host.configure(identity, settings) == Result.OK) == (line is None)
            assert bool(bus.written) == (line is None)


class FakeBus:
    """Registers without a core: a commit brings the bank into use; records what is written."""

    def __init__(self):
        self.map = read_registers()
        self.written, self.is_loaded = [], False

    def read(self, offset: int) -> int:
        return 1 | self.is_loaded << 4 if offset == self.map["load_status"].address else 0

    def write(self, offset: int, word: int) -> None:
        self.written.append((offset, word))
        self.is_loaded = self.is_loaded or (offset, word) == (self.map["load_command"].address, 2)


def test_host_loads_a_whole_image_alike_in_c_and_in_python(tmp_path):
    image, library = image_of(ROOT / "weights" / "spheiro"), compile_host(tmp_path)
    written = []
    for bus in (FakeBus(), FakeBus()):
        host = Host(bus) if written else CHost(library, bus)
        assert host.crc32(image.data) == image.crc32
        assert host.load(image.data, image.crc32, 1) == Result.OK
        written.append(bus.written)
    assert written[0] == written[1]
    address = read_registers()["load_word"].address
    assert [word for offset, word in written[0] if offset == address] == image.words.tolist()


CPP = """
#include "gravcomp.h"
#include "gravcomp_registers.h"

static std::uint32_t read_zero(void *, std::uint32_t) { return 0; }
static void write_nothing(void *, std::uint32_t, std::uint32_t) {}

int main()
{
    const gravcomp_bus bus = {read_zero, write_nothing, nullptr};
    gravcomp_identity identity;

    gravcomp_kick(&bus);
    return gravcomp_open(&bus, &identity) == GRAVCOMP_NOT_FOUND ? 0 : 1;
}
"""


def test_host_links_into_a_program_in_cpp(tmp_path):
    (tmp_path / "main.cpp").write_text("#include <cstdint>\n" + CPP)
    objects = [tmp_path / "gravcomp.o", tmp_path / "main.o"]
    strict = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{ROOT / 'host'}"]
    subprocess.run(["cc", "-std=c99", *strict, "-c", ROOT / "host" / "gravcomp.c", "-o", objects[0]], check=True)
    subprocess.run(["c++", "-std=c++11", *strict, "-c", tmp_path / "main.cpp", "-o", objects[1]], check=True)
    subprocess.run(["c++", *objects, "-o", tmp_path / "main"], check=True)
    subprocess.run([tmp_path / "main"], check=True)


def test_host_compiles_as_c99_with_every_warning_an_error(tmp_path):
    assert compile_host(tmp_path, "-O2", "-DBASE=0x40000000").exists()
