"""Driver of gc_system in Python: the twin of host/gravcomp.c, function by function.

A bus is any object with read(offset) -> word and write(offset, word), 32-bit registers at byte offsets, and, if it can
read several at once, read_run(offset, n) -> words. An image is what `gravcomp image` writes.
"""

import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from enum import IntEnum
from functools import cached_property
from pathlib import Path
from typing import Protocol

from gravcomp.core.folder import folder_hash
from gravcomp.driver.registers import read_registers
from gravcomp.facts import LOAD_KEY, MAX_AXES, WORDS_PER_KICK, Event
from gravcomp.facts import State as Brakes
from gravcomp.robot.machine import load_machine
from gravcomp.twin.encoder import DecoderConfig

CONTROL_POLLS = 1000
HASH_WORDS = 8
WORD_MAX = 2**32 - 1
PERIOD_MAX = MAGNITUDE_MAX = 2**31 - 1
WRONG_AXES = "axes: not those of the core; give those of the machine folder of its ROM, or build it with your ROM"
WRONG_CLOCK = "clock_hz: not that of the core; give that of the machine folder of its ROM, or build it with your ROM"


class Bus(Protocol):
    """Access to one 32-bit register."""

    def read(self, offset: int) -> int: ...

    def write(self, offset: int, word: int) -> None: ...


class Result(IntEnum):
    """Outcome of a call. FAULT: stopped by a fault, see State.fault.

    REFUSED: an image of a wrong length or CRC; a move.
    TOO_FAST: Settings.speed_max_counts_per_s is more than the core can measure with its encoder filter. BAD_PERIOD:
    Settings.index_period is not a multiple of 4.
    UNUSABLE: settings with which the brakes can never be released, see complaint. WRONG_CLOCK: Settings.clock_hz is not
    that of the core. WRONG_AXES: the core has another number of axes than the machine.
    """

    OK = 0
    NOT_FOUND = 1
    WRONG_VERSION = 2
    TIMEOUT = 3
    FAULT = 4
    REFUSED = 5
    NOT_LOADABLE = 6
    TOO_FAST = 7
    BAD_PERIOD = 8
    UNUSABLE = 9
    WRONG_CLOCK = 10
    WRONG_AXES = 11


@dataclass(frozen=True)
class Identity:
    """What does not change: axes, neurons and neurons per clock, whether the network's form is the lean one, Hz of the
    core's clock, SHA-256 in eight words, trained range in counts.

    filter_samples: clocks that a level of an encoder must last.
    """

    axes: int
    hidden: int
    lanes: int
    lean: bool
    clock_hz: int
    filter_samples: int
    weights_hash: tuple[int, ...]
    compensation_hash: tuple[int, ...]
    trained_low: tuple[int, ...]
    trained_high: tuple[int, ...]


@dataclass(frozen=True)
class Settings:
    """Limits and times; clock_hz and expected_weights, the first word of its hash, are those of the machine folder that
    the host means, see machine_settings.

    index_period: counts from index to index, 0 where there is one. speed_max_counts_per_s: 0 allows no motion.
    margin_counts: allowed beyond the trained range. current_slew_ua: per result. brake_us: for a brake to close and for
    the motors to take the load. The other times are the longest in saturation, from kick to kick and result to result,
    with a command further than command_bound_ua from the current asked for, and until the motors have taken the load;
    brake_test_us is that of a phase of the test of a brake, 0 without a test.
    """

    axes: int
    clock_hz: int
    expected_weights: int
    index_position: tuple[int, ...]
    index_period: tuple[int, ...]
    margin_counts: tuple[int, ...]
    speed_max_counts_per_s: tuple[int, ...]
    current_limit_ua: tuple[int, ...]
    current_slew_ua: tuple[int, ...]
    command_bound_ua: tuple[int, ...]
    tick_us: int
    saturation_us: int
    watchdog_us: int
    result_us: int
    brake_us: int
    command_us: int
    hold_us: int
    brake_test_us: int = 0


@dataclass(frozen=True)
class State:
    """Everything as of one clock. Sets of axes have axis 1 in bit 0; counts, clocks per four counts, mN, uA."""

    result_number: int
    missed_ticks: int
    brakes: int
    released: int
    run: int
    busy: int
    clamped: int
    saturated: int
    limited: int
    reached: int
    referenced: int
    illegal: int
    glitch: int
    speed_valid: int
    speed_zero: int
    deviates: int
    position: tuple[int, ...]
    speed_period: tuple[int, ...]
    force_mn: tuple[int, ...]
    current_ua: tuple[int, ...]
    command_ua: tuple[int, ...]
    position_now: tuple[int, ...]
    cause: int
    fault: int
    first_cause: int
    first_position: tuple[int, ...]


def machine_settings(folder: Path | str) -> dict[str, int]:
    """What the Settings of a machine folder's core hold of it. Raises InputError as load_machine and folder_hash do."""
    machine = load_machine(folder)
    return {
        "axes": machine.n_axes,
        "clock_hz": int(machine.clock_hz),
        "expected_weights": int(folder_hash(folder, machine)[:8], 16),
    }


# Registers of one word in the order of their addresses, and those whose fields are fields of a State.
_FLAGS = ("status", "result_flags", "command_flags", "encoder_flags", "speed_flags")
STATE_WORDS = ("result_number", "missed_ticks", *_FLAGS, "cause", "fault", "first_cause")
_PER_AXIS = tuple(field.name for field in fields(Settings) if field.type == tuple[int, ...])


class Host:
    """The driver on a bus; what its methods do and return is said in host/gravcomp.h."""

    def __init__(self, bus: Bus):
        self._bus = bus
        self._map = read_registers()

    def open(self) -> tuple[Result, Identity | None]:
        if self._read("id") != self._map["id"].reset:
            return Result.NOT_FOUND, None
        if self._read("version") >> 8 != self._map["version"].reset >> 8:
            return Result.WRONG_VERSION, None
        if self._n_axes > MAX_AXES:
            return Result.WRONG_VERSION, None
        geometry = self._read("geometry")
        return Result.OK, Identity(
            axes=self._n_axes,
            hidden=self._map["geometry"].field("hidden", geometry),
            lanes=self._map["geometry"].field("lanes", geometry),
            lean=bool(self._map["geometry"].field("lean", geometry)),
            clock_hz=self._read("clock_hz"),
            filter_samples=self._map["encoder_geometry"].field("filter_samples", self._read("encoder_geometry")),
            weights_hash=self._words("weights_hash", HASH_WORDS),
            compensation_hash=self._words("compensation_hash", HASH_WORDS),
            trained_low=self._axes("trained_low"),
            trained_high=self._axes("trained_high"),
        )

    def complaint(self, identity: Identity, settings: Settings) -> str | None:
        hz = identity.clock_hz
        if settings.axes != identity.axes:
            return WRONG_AXES
        for name in _PER_AXIS:
            if len(getattr(settings, name)) != settings.axes:
                return f"{name}: {len(getattr(settings, name))} values; give one for each of {settings.axes} axes"
        if settings.clock_hz != hz:
            return WRONG_CLOCK
        for limit, slew, bound in _currents(settings):
            if line := _current_complaint(limit, slew, bound):
                return line
        if self._is_too_fast(identity, settings):
            return "speed_max_counts_per_s: more than the core can measure with its encoder filter"
        if any(period % 4 for period in settings.index_period):
            return "index_period: not a multiple of 4"
        results = max((limit + slew - 1) // slew + 1 for limit, slew, _ in _currents(settings))
        ramp = results * _clocks(hz, settings.tick_us) + _clocks(hz, settings.brake_us)
        if test := _clocks(hz, settings.brake_test_us):
            ramp += 4 * identity.axes * (test + 2) + 1
        if ramp > _clocks(hz, settings.hold_us):
            return "hold_us: shorter than the slew from 0 to current_limit_ua, brake_us and the test of the brakes"
        return None

    def _is_too_fast(self, identity: Identity, settings: Settings) -> bool:
        shortest = DecoderConfig(filter_samples=identity.filter_samples).shortest_period
        return any(speed > 0 and _period_min(identity, speed) <= shortest for speed in settings.speed_max_counts_per_s)

    def configure(self, identity: Identity, settings: Settings) -> Result:
        if settings.axes != identity.axes:
            return Result.WRONG_AXES
        if settings.clock_hz != identity.clock_hz:
            return Result.WRONG_CLOCK
        if self._is_too_fast(identity, settings):
            return Result.TOO_FAST
        if any(period % 4 for period in settings.index_period):
            return Result.BAD_PERIOD
        if self.complaint(identity, settings):
            return Result.UNUSABLE
        hz = identity.clock_hz
        self._write("expected_weights", settings.expected_weights)
        self._write("tick_clocks", _clocks(hz, settings.tick_us))
        for name in ("saturation", "watchdog", "result", "brake", "command", "hold", "brake_test"):
            self._write(f"{name}_clocks", _clocks(hz, getattr(settings, f"{name}_us")))
        for axis in range(identity.axes):
            self._write("index_position", settings.index_position[axis], axis)
            self._write("index_period", settings.index_period[axis], axis)
            self._write("window_low", identity.trained_low[axis] - settings.margin_counts[axis], axis)
            self._write("window_high", identity.trained_high[axis] + settings.margin_counts[axis], axis)
            for name in ("current_limit_ua", "current_slew_ua", "command_bound_ua"):
                self._write(name, getattr(settings, name)[axis], axis)
            self._write("period_min_clocks", _period_min(identity, settings.speed_max_counts_per_s[axis]), axis)
        return Result.OK

    def home(self, axes: int) -> Result:
        if self._control("home_enable", 0) != Result.OK:
            return Result.TIMEOUT
        return self._control("home_enable", axes)

    def start(self) -> None:
        self._command("start")

    def tick(self, is_on: bool) -> Result:
        return self._control("tick_enable", int(is_on))

    def wait(self, number: int, polls: int) -> Result:
        arrived = any(self._read("result_number") != number for _ in range(polls))
        return Result.OK if arrived else Result.TIMEOUT

    def release(self, polls: int) -> Result:
        result, brakes, cause = self.stop(), Brakes.FAULT, 0
        while result == Result.OK and (brakes != Brakes.BRAKED or cause):
            if polls == 0:
                return Result.FAULT if cause else Result.TIMEOUT
            polls -= 1
            brakes, cause = self._poll_brakes()
            if brakes == Brakes.FAULT and not cause:
                self.clear_faults((1 << self._map["fault"].fields["clear"][1]) - 1)
        if result == Result.OK:
            result = self._control("enable", 1)
        while result == Result.OK and brakes != Brakes.RUN:
            if polls == 0:
                return Result.TIMEOUT
            polls -= 1
            brakes, _ = self._poll_brakes()
            if brakes == Brakes.FAULT:
                return Result.FAULT
        return result

    def stop(self) -> Result:
        return self._control("enable", 0)

    def kick(self) -> None:
        self._command("kick")

    def clear_faults(self, faults: int) -> None:
        self._write("fault", faults)

    def core_runs(self) -> bool:
        return bool(self._map["guards"].field("core_clock", self._read("guards")))

    def brakes_fed(self) -> int:
        return self._map["guards"].field("feedback", self._read("guards"))

    def clear_encoders(self) -> None:
        self._command("clear_encoder")

    def read(self) -> State:
        # Its first word freezes the rest.
        values = dict(zip(STATE_WORDS, self._words("result_number", len(STATE_WORDS)), strict=True))
        for name in _FLAGS:
            word, register = values.pop(name), self._map[name]
            values |= {field: register.field(field, word) for field in register.fields}
        values["brakes"] = values.pop("state")
        for name in (field.name for field in fields(State) if field.name not in values):
            values[name] = self._axes(name)
        return State(**values)

    def crc32(self, image: bytes) -> int:
        return zlib.crc32(image)

    def load(self, image: bytes, crc: int, polls: int, progress: Callable[[], object] = lambda: None) -> Result:
        """progress is called after each word."""
        if not self._loader("loadable"):
            return Result.NOT_LOADABLE
        self._write("load_unlock", LOAD_KEY)
        self._send_image(image, progress)
        bank = self._loader("bank")
        self._write("load_crc", crc)
        self._command("commit", "load_command")
        for _ in range(polls):
            status = self._read("load_status")
            if self._map["load_status"].field("bank", status) != bank:
                return Result.OK
            if self._map["load_status"].field("bad", status):
                return Result.REFUSED
        return Result.TIMEOUT

    def use_rom(self, polls: int) -> Result:
        self._write("load_unlock", LOAD_KEY)
        self._command("begin_image", "load_command")
        self._command("use_rom", "load_command")
        self._write("load_unlock", 0)
        for _ in range(polls):
            status = self._read("load_status")
            if not any(self._map["load_status"].field(name, status) for name in ("bank", "bad")):
                return Result.OK
        return Result.TIMEOUT

    def bank_crc(self) -> int:
        return self._read("bank_crc")

    def interrupt_on(self, events: int) -> None:
        self._write("interrupt_enable", events)

    def interrupts(self) -> Event:
        events = self._read("interrupt_status")
        self._write("interrupt_status", events)
        return Event(events)

    def _read(self, name: str, axis: int = 0) -> int:
        return self._bus.read(self._map[name].address + 4 * axis)

    def _write(self, name: str, word: int, axis: int = 0) -> None:
        self._bus.write(self._map[name].address + 4 * axis, word & WORD_MAX)

    def _words(self, name: str, count: int) -> tuple[int, ...]:
        if read_run := getattr(self._bus, "read_run", None):
            return tuple(read_run(self._map[name].address, count))
        return tuple(self._read(name, i) for i in range(count))

    @cached_property
    def _n_axes(self) -> int:
        return self._map["geometry"].field("outputs", self._read("geometry"))

    def _axes(self, name: str) -> tuple[int, ...]:
        return tuple(word - (word >> 31 << 32) for word in self._words(name, self._n_axes))

    def _loader(self, field: str) -> int:
        return self._map["load_status"].field(field, self._read("load_status"))

    def _send_image(self, image: bytes, progress: Callable[[], object]) -> None:
        self._command("begin_image", "load_command")
        for i in range(len(image) // 4):
            if i % WORDS_PER_KICK == 0:
                self.kick()
            self._write("load_word", int.from_bytes(image[4 * i : 4 * i + 4], "little"))
            progress()

    def _command(self, name: str, register: str = "command") -> None:
        low, _ = self._map[register].fields[name]
        self._write(register, 1 << low)

    def _control(self, name: str, value: int) -> Result:
        """Change a field of control; OK once the core has it."""
        low, width = self._map["control"].fields[name]
        mask = (1 << width) - 1 << low
        control = self._read("control") & ~mask | value << low & mask
        self._write("control", control)
        arrived = any(self._read("control_now") == control for _ in range(CONTROL_POLLS))
        return Result.OK if arrived else Result.TIMEOUT

    def _poll_brakes(self) -> tuple[int, int]:
        """The state of the brakes and the causes present, after a kick."""
        self.kick()
        self._read("result_number")
        status = self._read("status")
        return self._map["status"].field("state", status), self._read("cause")


def _currents(settings: Settings) -> Iterator[tuple[int, int, int]]:
    """Limit, slew and bound of each axis."""
    return zip(settings.current_limit_ua, settings.current_slew_ua, settings.command_bound_ua, strict=True)


def _current_complaint(limit: int, slew: int, bound: int) -> str | None:
    for name, value in (("current_limit_ua", limit), ("current_slew_ua", slew), ("command_bound_ua", bound)):
        if value > MAGNITUDE_MAX:
            return f"{name}: above 2147483647"
    if limit == 0:
        return "current_limit_ua: 0 carries no load"
    if slew == 0:
        return "current_slew_ua: 0 never reaches current_limit_ua"
    return None


def _period_min(identity: Identity, speed: int) -> int:
    return min(4 * identity.clock_hz // speed, PERIOD_MAX) if speed else 0


def _clocks(hz: int, us: int) -> int:
    return min(us * hz // 1_000_000, WORD_MAX)
