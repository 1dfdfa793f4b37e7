"""What gc_system does while faults are injected: bring-up by the driver, then a pose that is held."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from gravcomp.driver.host import Host, Result, Settings
from gravcomp.driver.registers import read_registers
from gravcomp.errors import InputError
from gravcomp.facts import Cause
from gravcomp_lab.inject.bench import Session

# Of the host's loop: kicks the watchdog and reads all that a controller reads.
LOOP_AXI_CLOCKS = 512
POSE = (2002, -3002, 4002)
INDEX_PHASE = 2
# Between two results, core clocks: a third of the time the pipeline is at work.
TICK_US = 4
# A command may come a tick of 160 clocks sooner or later.
SHIFT = 165


# From the edge of enable on, until the motors are about to carry the load and the test of the brakes to begin.
CLOCKS_TO_TEST = 600


class End(Enum):
    """How a bring-up ends: all healthy, brakes engaged; while the brakes are tested, one by one; in RUN."""

    BRAKED = 0
    TEST = 1
    RUN = 2


@dataclass(frozen=True)
class Scene:
    """What the system does meanwhile. image: words that are loaded and in use, none for the ROM."""

    name: str
    end: End = End.RUN
    image: bytes = b""


class _Recorder:
    """A bus that passes what the driver does on to the loop of the bench."""

    def __init__(self, session: Session):
        self._session = session

    def read(self, offset: int) -> int:
        self._session.tell("r", offset)
        return 0

    def write(self, offset: int, word: int) -> None:
        self._session.tell("w", offset, word)


def bring_up(session: Session, scene: Scene) -> None:
    """Configure, load, home and, as far as the scene says so, release, all by the driver. InputError when it fails."""
    index = [count - (count - INDEX_PHASE) % 4 for count in POSE]
    session.tell("i", *index)
    host = Host(session)
    result, identity = host.open()
    _need(result, "open")
    _need(host.configure(identity, settings(identity, index)), "configure")
    if scene.image:
        _need(host.load(scene.image, zlib.crc32(scene.image), 1000), "load")
    _need(host.home(7), "home")
    # In phase 0, as the pins are after reset; the phase of the index comes by once before it.
    session.tell("e", *(count - 6 for count in index))
    session.ask("t", *POSE)
    _need(host.tick(True), "tick")
    host.kick()
    session.tell("c", 2000)
    host.clear_faults((1 << len(Cause)) - 1)
    host.kick()
    if scene.end == End.TEST:
        session.tell("c", 500)  # until the kick has arrived
        _need(host._control("enable", 1), "enable")
        session.tell("c", CLOCKS_TO_TEST)
        host.kick()
    if scene.end == End.RUN:
        _need(host.release(1000), "release")
        host.kick()
        session.tell("c", 4000)


def settings(identity, index: Sequence[int]) -> Settings:
    """Limits that the pose does not exceed; time-outs that all end well within a run after a fault."""
    axes = identity.axes
    return Settings(
        axes=axes,
        clock_hz=identity.clock_hz,
        expected_weights=identity.weights_hash[0],
        index_position=tuple(index),
        index_period=(0,) * axes,
        margin_counts=(100,) * axes,
        speed_max_counts_per_s=(1_000_000,) * axes,
        current_limit_ua=(10_000_000,) * axes,
        current_slew_ua=(400_000,) * axes,
        tick_us=TICK_US,
        saturation_us=100,
        watchdog_us=250,
        result_us=50,
        brake_us=10,
        brake_test_us=10,
        command_bound_ua=(50_000,) * axes,
        command_us=50,
        hold_us=2000,
    )


def hold(session: Session, moments: Sequence[int], horizon: int, stride: int) -> list[list[bool]]:
    """Hold the pose without a fault, saved at the moments (clocks). Per store: bits that changed, words that were read.

    The host kicks and reads; each axis moves by one count to and fro.
    """
    host, third = Host(_Recorder(session)), LOOP_AXI_CLOCKS // 3
    registers = read_registers()
    session.tell("@", 0)
    host.kick()
    for axis in range(len(POSE)):
        session.tell("+", axis, 1)
    session.tell("@", third)
    for name in (
        "result_number",
        "status",
        "result_flags",
        "command_flags",
        "encoder_flags",
        "speed_flags",
        "cause",
        "fault",
    ):
        host._bus.read(registers[name].address)
    session.tell("@", 2 * third)
    for axis in range(len(POSE)):
        session.tell("+", axis, -1)
    session.tell("h", LOOP_AXI_CLOCKS, horizon, stride, SHIFT, *moments)
    return [[digit == "1" for digit in session.answer()] for _ in range(session.n_stores)]


def _need(result: Result, what: str) -> None:
    if result != Result.OK:
        raise InputError(f"bench: {what} ended with {result.name}; the design does not hold a pose without a fault")
