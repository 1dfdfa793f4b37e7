"""Driver of gc_motion, setpoints, servo and recorder: the twin of host/gravcomp_motion.c, function by function."""

from dataclasses import dataclass, fields

from gravcomp.driver.host import WORD_MAX, Bus, Result
from gravcomp.driver.registers import MOTION_XML, read_registers
from gravcomp.facts import RECORD_WINDOW
from gravcomp.twin.recorder import Mode, words_of


@dataclass(frozen=True)
class MotionSettings:
    """Gains and limits in the units of their registers: docs/guide/motion.md. servo_filter and servo_speed_feed
    (0 or 1) are those of all axes."""

    servo_filter: int
    servo_speed_feed: int
    servo_proportional: tuple[int, ...]
    servo_integral: tuple[int, ...]
    servo_derivative: tuple[int, ...]
    servo_limit_ua: tuple[int, ...]
    following_max: tuple[int, ...]
    speed_max: tuple[int, ...]
    acceleration_max: tuple[int, ...]


@dataclass(frozen=True)
class MotionState:
    """As of one clock. moves: commands that came, modulo 256; following: set of axes; counts and uA per axis."""

    moves: int
    ready: int
    refused: int
    following: int
    setpoint: tuple[int, ...]
    correction_ua: tuple[int, ...]


@dataclass(frozen=True)
class RecordStatus:
    """count: whole records since recording began; lost: those that found no room."""

    mode: int
    triggered: int
    done: int
    count: int
    lost: int


def is_there(bus: Bus) -> bool:
    """Whether the core was built with gc_motion; the registers of the others are not there without."""
    register = read_registers()["encoder_geometry"]
    return bool(register.field("motion", bus.read(register.address)))


class Motion:
    """The driver on the bus of a core with gc_motion and so many axes; host/gravcomp_motion.h says what each does."""

    def __init__(self, bus: Bus, axes: int):
        self._bus, self._axes, self._taken = bus, axes, 0
        self._map = read_registers(MOTION_XML)

    def configure(self, settings: MotionSettings) -> None:
        feed, _ = self._map["servo_filter"].fields["speed_feed"]
        self._write("servo_filter", settings.servo_filter | settings.servo_speed_feed << feed)
        for field in fields(settings)[2:]:
            self._write_axes(field.name, getattr(settings, field.name))

    def move(self, target: tuple[int, ...], ticks: int, polls: int) -> Result:
        due = (self._status()["moves"] + 1) % 256
        self._write_axes("move_target", target)
        self._write("move_ticks", ticks)
        self._write("motion_command", 1)
        for _ in range(polls):
            status = self._status()
            if status["moves"] == due:
                return Result.REFUSED if status["refused"] else Result.OK
        return Result.TIMEOUT

    def read(self) -> MotionState:
        # Its first word freezes the rest.
        return MotionState(
            **self._status(), setpoint=self._signed("setpoint"), correction_ua=self._signed("correction_ua")
        )

    def record(self, mode: Mode, polls: int, *, mean: bool = False, ticks: int = 0, before: int = 0) -> Result:
        self._write("record_control", 0)
        if not self._records(Mode.OFF, polls):
            return Result.TIMEOUT
        self._taken = 0
        if mode == Mode.OFF:
            return Result.OK
        self._write("record_taken", 0)
        self._write("record_before", before)
        self._write("record_control", mode | mean << 2 | ticks << 4)
        return Result.OK if self._records(mode, polls) else Result.TIMEOUT

    def record_status(self) -> RecordStatus:
        status, register = self._read("record_status"), self._map["record_status"]
        flags = {name: register.field(name, status) for name in ("mode", "triggered", "done")}
        return RecordStatus(**flags, count=self._read("record_count"), lost=self._read("record_lost"))

    def take(self, most: int) -> list[int]:
        status, words, size = self.record_status(), [], words_of(self._axes)
        if status.mode == Mode.FAULT and not status.triggered:
            return words
        left = min(most, (status.count - self._taken) % 2**32)
        while left:
            n = min(left, RECORD_WINDOW // size)
            words += self._run("record_word", n * size)
            left -= n
            self._taken = (self._taken + n) % 2**32
            self._write("record_taken", self._taken)
        return words

    def _records(self, mode: Mode, polls: int) -> bool:
        """Whether the core has that mode, within so many polls."""
        register = self._map["record_status"]
        return any(register.field("mode", self._read("record_status")) == mode for _ in range(polls))

    def _status(self) -> dict[str, int]:
        status, register = self._read("motion_status"), self._map["motion_status"]
        return {name: register.field(name, status) for name in register.fields}

    def _read(self, name: str) -> int:
        return self._bus.read(self._map[name].address)

    def _run(self, name: str, n: int) -> list[int]:
        first = self._map[name].address
        if read_run := getattr(self._bus, "read_run", None):
            return list(read_run(first, n))
        return [self._bus.read(first + 4 * i) for i in range(n)]

    def _signed(self, name: str) -> tuple[int, ...]:
        return tuple(word - (word >> 31 << 32) for word in self._run(name, self._axes))

    def _write(self, name: str, word: int) -> None:
        self._bus.write(self._map[name].address, word & WORD_MAX)

    def _write_axes(self, name: str, values: tuple[int, ...]) -> None:
        words, first = [value & WORD_MAX for value in values], self._map[name].address
        if write_run := getattr(self._bus, "write_run", None):
            write_run(first, words)
            return
        for axis, word in enumerate(words):
            self._bus.write(first + 4 * axis, word)
