"""gc_system with motion, through its pins: three masses with friction, a host in Python or C on AXI4-Lite.

The world: each axis is a mass with Coulomb friction and a load: at home the feed-forward of the core, and what the
core does not know. Units are counts, ticks and uA.
"""

import os
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.task import bridge, resume
from cocotb.triggers import Timer

from c_motion import CMotion, compile_motion
from codes import hash_under_test, pack, unpack, weights_under_test
from gravcomp.core.formats import COUNT_BITS
from gravcomp.driver.host import Brakes, Host, Result, Settings, machine_settings
from gravcomp.driver.motion import Motion, MotionSettings, is_there
from gravcomp.driver.registers import MOTION_XML, read_registers
from gravcomp.facts import RECORD_WINDOW, Cause
from gravcomp.logs.records import measured_csv, records_of
from gravcomp.robot.machine import load_machine
from gravcomp.twin.recorder import Mode, words_of
from gravcomp.twin.servo import gains_of
from gravcomp_lab.benches.axi import BusError, SimulatedBus
from gravcomp_lab.benches.changes import until
from runner import BUILD, simulate
from support.board import AXES, INDEX, Board

CLOCK_NS, TICK_US, STEP_CLOCKS = 25, 3, 10  # a count takes a step at least
TICK_CLOCKS = TICK_US * 1000 // CLOCK_NS
MASS_UA, FRICTION_UA = 20_000.0, 2_000.0  # uA per count and tick^2
UNKNOWN_UA = np.array([8_000.0, 0.0, -6_000.0])
SENSE_OFFSET_UA, SLEW_UA = 111, 400_000
OMEGA = 0.12  # per tick, of the triple pole
FREE = 2**32 - 1
POLLS = 400
# These axes turn on the spot within a step: no sign of a broken wire (gc_edge_watch).
NIMBLE = {"reversal_clocks_g": STEP_CLOCKS, "dither_clocks_g": STEP_CLOCKS}
TARGET = (122, -78, 42)


def gains(speed_feed: int = 0, **changes) -> MotionSettings:
    """Poles of a mass at OMEGA, all axes alike."""
    one = gains_of(3 * OMEGA**2 * MASS_UA, OMEGA**3 * MASS_UA, 3 * OMEGA * MASS_UA, 1.0, 1, 400_000)
    values = {
        "servo_proportional": one.proportional,
        "servo_integral": one.integral,
        "servo_derivative": one.derivative,
        "servo_limit_ua": one.limit,
        "following_max": 60,
        "speed_max": FREE,
        "acceleration_max": FREE,
    }
    per_axis = {name: (changes.get(name, value),) * AXES for name, value in values.items()}
    return MotionSettings(one.filter, servo_speed_feed=speed_feed, **per_axis)


SETTINGS = Settings(
    **machine_settings(weights_under_test()),
    index_position=(INDEX,) * AXES,
    index_period=(0,) * AXES,
    margin_counts=(1000,) * AXES,
    speed_max_counts_per_s=(15_000_000,) * AXES,
    current_limit_ua=(4_000_000,) * AXES,
    current_slew_ua=(SLEW_UA,) * AXES,
    command_bound_ua=(500_000,) * AXES,
    tick_us=TICK_US,
    saturation_us=200,
    watchdog_us=2000,
    result_us=200,
    brake_us=10,
    command_us=100,
    hold_us=200,
)


class Robot(Board):
    """The board's axes move as masses do. jammed: axes that do not; commands: what each tick had (k, n), uA."""

    async def start(self) -> None:
        await super().start()
        self.dut.sense_valid.value = 0
        self.x, self.v = np.array(self.position, float), np.zeros(AXES)
        self.load, self.jammed, self.commands = np.zeros(AXES), np.zeros(AXES, bool), []

    def world(self) -> None:
        self.x = np.array(self.position, float)
        cocotb.start_soon(self._world())

    def command(self) -> np.ndarray:
        return unpack([int(self.dut.drive_current.value)], COUNT_BITS, AXES)[0].astype(float)

    async def _world(self) -> None:
        dut = self.dut
        dut.sense_valid.value = 2**AXES - 1
        for step in range(10**6):
            command = self.command()
            if step % (TICK_CLOCKS // STEP_CLOCKS) == 0:
                self.commands.append(command)
            dut.sense_current.value = pack(command + SENSE_OFFSET_UA, 32)
            released = np.array([int(dut.brake_release.value) >> k & 1 for k in range(AXES)], bool)
            self._step((command - self.load) / MASS_UA, released & ~self.jammed, STEP_CLOCKS / TICK_CLOCKS)
            await Timer(STEP_CLOCKS * CLOCK_NS, "ns")

    def _step(self, push: np.ndarray, free: np.ndarray, ticks: float) -> None:
        """Euler's step of so many ticks; friction holds what it can, and never turns a mass back."""
        rub = FRICTION_UA / MASS_UA * ticks
        pushed = self.v + push * ticks
        self.v = np.where(free, np.sign(pushed) * np.maximum(np.abs(pushed) - rub, 0), 0)
        self.x = self.x + self.v * ticks
        near = [p + int(np.clip(np.floor(x) - p, -1, 1)) for p, x in zip(self.position, self.x, strict=True)]
        if near != self.position:
            self.position = near
            self.drive()


async def prepare(dut) -> tuple[Robot, SimulatedBus, Host]:
    """A homed robot whose load is known, but for UNKNOWN_UA; the host has written its limits."""
    robot = Robot(dut)
    await robot.start()
    bus = SimulatedBus(robot.registers)
    host = Host(bus)
    await robot.home()

    def limits() -> np.ndarray:
        result, identity = host.open()
        assert result == Result.OK
        assert is_there(bus)
        assert host.configure(identity, SETTINGS) == Result.OK
        number = host.read().result_number
        assert host.tick(True) == Result.OK
        assert host.wait(number, POLLS) == Result.OK
        return np.array(host.read().current_ua, float)

    robot.load = await bridge(limits)() + UNKNOWN_UA
    robot.world()
    return robot, bus, host


def held_for(host: Host, wait, ticks: int) -> None:
    """Kick while so many ticks pass."""
    for _ in range(ticks // 20):
        host.kick()
        wait(20 * TICK_CLOCKS)


@cocotb.test()
async def moves_from_a_to_b_and_records_it(dut):
    """No jump at release or at the start of a move; setpoints are the twin's; records are what was commanded."""
    robot, bus, host = await prepare(dut)
    motion, wait = Motion(bus, AXES), resume(robot.clocks)
    ticks = 60

    def session() -> tuple:
        motion.configure(gains())
        assert motion.move(TARGET, ticks, POLLS) == Result.REFUSED  # the brakes are engaged
        assert host.release(POLLS) == Result.OK
        assert motion.record(Mode.FREE, POLLS, ticks=3) == Result.OK
        held_for(host, wait, 80)
        rest = motion.read()
        words = motion.take(1000)
        assert (state := host.read()).brakes == Brakes.RUN, state
        assert motion.move(TARGET, ticks, POLLS) == Result.OK
        assert motion.move(TARGET, ticks, POLLS) == Result.REFUSED  # one is under way
        for _ in range(6):
            held_for(host, wait, 20)
            words += motion.take(1000)
        assert motion.record_status().lost == 0
        return rest, motion.read(), host.read(), words

    rest, end, state, words = await bridge(session)()
    assert (state.brakes, state.fault) == (Brakes.RUN, 0)
    assert (end.setpoint, end.ready) == (TARGET, 1)
    assert np.abs(np.array(robot.position) - TARGET).max() <= 4
    assert np.abs(np.diff(robot.commands, axis=0)).max() <= SLEW_UA + 1
    # What the core does not know is the servo's, but for what friction holds.
    assert np.abs(np.array(rest.correction_ua) - UNKNOWN_UA).max() <= 1.5 * FRICTION_UA
    assert np.abs(np.array(rest.setpoint) - INDEX).max() == 0

    records = records_of(words, AXES)
    assert not records.was_lost.any()
    assert not records.is_stale.any()
    np.testing.assert_array_equal(np.diff(records.tick), 8)
    assert set(records.status & 0b1111) == {Brakes.RUN | 8}
    commands = np.array(robot.commands)
    for axis in range(AXES):
        assert np.isin(records.command[:, axis], commands[:, axis]).all()
        assert np.isin(records.sense[:, axis] - SENSE_OFFSET_UA, commands[:, axis]).all()
    travelled = records.count[-1] - records.count[0]
    assert np.abs(travelled - (np.array(TARGET) - INDEX)).max() <= 6
    text = measured_csv(records, load_machine(weights_under_test()), TICK_US * 1e-6)
    assert len(text.splitlines()) == len(records.tick) + 1
    assert text.startswith("t_s,q1_m,q2_m,q3_m,v1_mps,v2_mps,v3_mps,i1_a,i2_a,i3_a\n")


@cocotb.test()
async def following_error_trips_and_the_records_show_it(dut):
    """A jam: the cause of the fault, the brakes, what came before in the ring; then released again without a jump."""
    robot, bus, host = await prepare(dut)
    motion, wait = Motion(bus, AXES), resume(robot.clocks)
    before = 12

    def session() -> tuple:
        motion.configure(gains())
        assert host.release(POLLS) == Result.OK
        assert motion.record(Mode.FAULT, POLLS, before=before) == Result.OK
        held_for(host, wait, 40)
        assert motion.take(1000) == []  # nothing is to be had before the fault
        robot.jammed[1] = True
        assert motion.move(TARGET, 60, POLLS) == Result.OK
        for _ in range(POLLS):
            host.kick()
            if (state := host.read()).brakes == Brakes.FAULTED:
                break
        frozen = motion.read()
        wait(15 * TICK_CLOCKS)
        words = motion.take(20)
        robot.jammed[1] = False
        host.kick()
        assert host.release(POLLS) == Result.OK
        began = len(robot.commands)
        held_for(host, wait, 40)
        return state, frozen, words, began, motion.read(), host.read()

    state, frozen, words, began, after, again = await bridge(session)()
    assert Cause.FOLLOWING.mask == state.first_cause == state.fault
    assert state.command_ua == (0, 0, 0)
    assert frozen.correction_ua == (0, 0, 0)
    assert (frozen.ready, frozen.following) == (0, 0)
    records = records_of(words, AXES)
    faults = records.status >> 4
    first = int(np.flatnonzero(faults)[0])
    assert first == before
    assert set(faults[first:]) == {Cause.FOLLOWING.mask}
    assert not records.command[first + 1 :].any()
    assert records.command[:first].all()
    assert (again.brakes, again.fault) == (Brakes.RUN, 0)
    assert np.abs(np.array(after.setpoint) - robot.position).max() <= 4
    assert np.abs(np.diff(robot.commands[began:], axis=0)).max() <= SLEW_UA + 1


@cocotb.test()
async def c_and_python_do_the_same(dut):
    """The same calls give the same answers and the same writes."""
    answers, written = {}, {}
    for name in ("C", "Python"):
        robot, bus, host = await prepare(dut)
        wait = resume(robot.clocks)
        motion = CMotion(Path(os.environ["LIBRARY"]), bus, AXES) if name == "C" else Motion(bus, AXES)
        bus.written.clear()
        answers[name] = await bridge(session)(motion, host, wait)
        motion_only = read_registers(MOTION_XML)["move_ticks"].address
        written[name] = [access for access in bus.written if access[0] >= motion_only]
    assert answers["C"] == answers["Python"]
    assert written["C"] == written["Python"]


def session(motion: Motion | CMotion, host: Host, wait) -> list:
    motion.configure(gains(speed_feed=1))
    answers = [motion.move(TARGET, 60, POLLS), motion.record(Mode.SINGLE, POLLS, mean=True, ticks=1)]
    wait(30 * TICK_CLOCKS)
    answers += [motion.record_status(), len(motion.take(1000)), motion.record_status(), motion.take(1000)]
    answers += [motion.record(Mode.OFF, POLLS), motion.read()]
    assert answers[0] == Result.REFUSED
    assert answers[2].done == 1
    assert answers[3] == answers[2].count * words_of(AXES) > 0
    return answers


@cocotb.test()
async def registers_of_motion(dut):
    """Reset values, bit by bit what is written, errors where nothing is; gc_system's own are as they were."""
    robot = Robot(dut)
    await robot.start()
    registers, rng, written = robot.registers, np.random.default_rng(41), {}
    cocotb.log.info("seed 41")
    map_ = read_registers(MOTION_XML)
    places = {n: [r.address + 4 * k for k in range(min(r.count, AXES))] for n, r in map_.items()}
    for name, register in map_.items():
        for address in places[name]:
            if not register.readable:
                with pytest.raises(BusError, match="SLVERR"):
                    await registers.read_at(address)
                continue
            value = await registers.read_at(address)
            known = {"record_status": 10 << 8}.get(name, register.reset)
            assert name == "setpoint" or value == known, name
            if not register.writable:
                with pytest.raises(BusError, match="SLVERR"):
                    await registers.write_at(address, ~value)
    for name, register in map_.items():
        for address in places[name] if register.holding else ():
            written[address, name] = int(rng.integers(0, 2**32))
            await registers.write_at(address, written[address, name])
    for (address, name), word in written.items():
        assert await registers.read_at(address) == word & map_[name].holding, name
    window = map_["record_word"].address
    used = {a for of in places.values() for a in of} | set(range(window, window + 4 * RECORD_WINDOW, 4))
    for address in [a for a in range(0x800, 0x1000, 4) if a not in used][::11]:
        with pytest.raises(BusError, match="SLVERR"):
            await registers.read_at(address)
        with pytest.raises(BusError, match="SLVERR"):
            await registers.write_at(address, FREE)
    assert await registers.read("id") == 0x67636D70
    assert await registers.read("expected_weights") == 0
    await registers.write("expected_weights", int(hash_under_test()[:8], 16))
    assert await registers.read("expected_weights") == int(hash_under_test()[:8], 16)


@cocotb.test()
async def record_is_refused_while_the_core_stands(dut):
    """A read of a record does not hang the bus when the core's clock has stopped."""
    robot = Robot(dut)
    await robot.start()
    window = read_registers(MOTION_XML)["record_word"].address
    assert await robot.registers.read_at(window) == 0
    Board._clocks[0].stop()
    with pytest.raises(BusError, match="SLVERR"):
        await robot.registers.read_at(window + 4)
    Board._clocks[0].start()
    await until(dut.clk, "the core", lambda: dut.core_alive.value == 1, 1000)
    assert await robot.registers.read_at(window) == 0


def simulate_motion(tests: str, **generics: int) -> None:
    simulate(
        "gc_system",
        "test_rtl_system_motion",
        tests=tests,
        label=tests,
        generics={"lanes_g": 1, "loadable_g": "false", "motion_g": "true", **NIMBLE, **generics},
        environment={"LIBRARY": str(compile_motion(BUILD / "tb" / "motion-library"))},
    )


@pytest.mark.parametrize("tests", ["moves_from", "following_error", "registers_of_motion|record_is_refused"])
def test_system_moves_and_records(tests):
    simulate_motion(tests)


def test_drivers_of_motion_are_one():
    """A ring of seven records."""
    simulate_motion("c_and_python", record_bits_g=7)
