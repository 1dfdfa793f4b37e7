"""What a user does with a board behind a serial line: the verbs of `gravcomp board`, for Python.

    with Board(Line("/dev/ttyUSB0")) as board:
        for state in board.hold(load_limits(Path("limits.toml"), "weights/mine")):
            print(state.position)

The brakes are released by hold alone, and engaged whenever it ends, whatever ends it; a line that is cut ends it, too:
the core's watchdog is kicked through it.
"""

import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path

from gravcomp.core.image import Image
from gravcomp.driver.host import Bus, Host, Identity, Result, Settings, State, machine_settings
from gravcomp.driver.registers import read_registers
from gravcomp.driver.serial_bus import Line, Refused, SerialBus
from gravcomp.errors import InputError
from gravcomp.facts import Cause
from gravcomp.facts import State as Brakes
from gravcomp.robot.machine import load_machine
from gravcomp.twin.modbus import Count

POLLS = 200  # until the brakes are released, the first result has come or an image is in use
# Exchanges from kick to kick, at most; what the watchdog must wait for.
EXCHANGES_PER_KICK = 10
NO_REGISTER = 0xFFC
CLOCK_TOLERANCE = 0.01  # a crystal is a hundred times better, another clock a good deal worse
# What to do about a fault; the others say it in docs/guide/safety.md.
REMEDIES = {
    Cause.ESTOP: "release the emergency stop",
    Cause.ENCODER: "check the encoders' cables, then home again",
    Cause.CRC: "load the image again",
    Cause.ROM: "give the machine folder that the core was built with",
    Cause.POSITION: "move the robot back into its range",
    Cause.UNREFERENCED: "home first",
    Cause.WATCHDOG: "the line is too slow for watchdog_us; raise it, or the baud",
    Cause.SATURATION: "an effort is beyond current_limit_ua or the core's range; raise that limit, or lighten the load",
    Cause.HOLD: "the motors did not take the load in hold_us; raise current_limit_ua, current_slew_ua or hold_us",
}
# What a clamped count ends in: the command waits for an effort that the core does not know.
OF_CLAMPED = (Cause.SATURATION, Cause.HOLD)


@dataclass(frozen=True)
class Check:
    """One line of the self-test."""

    name: str
    is_right: bool
    found: str


class Board:
    """A core behind a serial line, found and of this driver's version. host: the driver; identity: what the core is.

    A bus of another kind may stand in for a line: one with ``line``, its name, and ``close``; if time does not pass for
    its robot as it does here, with ``now_s``, too.

    Raises InputError when nothing answers, when something else does, or another version.
    """

    def __init__(self, line: Line | Bus):
        self.bus = SerialBus(line) if isinstance(line, Line) else line
        self.now_s: Callable[[], float] = getattr(self.bus, "now_s", time.monotonic)
        self.host = Host(self.bus)
        self._map = read_registers()
        try:
            result, identity = self.host.open()
            if result == Result.NOT_FOUND:
                raise InputError(f"{self.bus.line}: answers, but is no gravcomp core; check --unit")
            if result == Result.WRONG_VERSION:
                raise InputError(
                    f"{self.bus.line}: {self._versions()}; build the core or install the driver of the other's version"
                )
        except InputError:
            self.close()
            raise
        self.identity: Identity = identity
        self.all_axes = (1 << identity.axes) - 1

    def close(self) -> None:
        self.bus.close()

    def __enter__(self) -> "Board":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def _versions(self) -> str:
        register = self._map["version"]
        core, driver = self.bus.read(register.address), register.reset
        text = [".".join(str(word >> shift & 255) for shift in (16, 8, 0)) for word in (core, driver)]
        return f"registers of version {text[0]}, the driver is for {text[1]}"

    def counts(self) -> dict[str, int]:
        """What the port itself has counted: frames answered and dropped, words written, exceptions."""
        return {count.name.lower(): self.bus.count(count) for count in Count}

    def check_machine(self, folder: Path | str) -> None:
        """InputError unless the core's ROM is that of the machine folder."""
        expected, identity = machine_settings(folder), self.identity
        mend = "give the folder that it was built with, or build it with this one"
        if expected["axes"] != identity.axes:
            raise InputError(
                f"{self.bus.line}: its axes are {identity.axes}, those of {folder} {expected['axes']}; {mend}"
            )
        if expected["clock_hz"] != identity.clock_hz:
            raise InputError(
                f"{self.bus.line}: its clock is {identity.clock_hz} Hz, that of {folder} {expected['clock_hz']}; {mend}"
            )
        built, given = identity.weights_hash[0], expected["expected_weights"]
        if given != built:
            raise InputError(f"{self.bus.line}: its ROM has the weights {built:08x}, {folder} has {given:08x}; {mend}")

    def load(self, image: Image | bytes, progress: Callable[[], object] = lambda: None) -> int:
        """Bring an image into use, between two results; returns its CRC-32. The brakes may be released.

        progress is called after each word. Raises InputError when the core refuses it, or was
        built without banks; it then goes on with what it had.
        """
        data = image if isinstance(image, bytes) else image.data
        crc = self.host.crc32(data)
        result = self.host.load(data, crc, POLLS, progress)
        if result == Result.NOT_LOADABLE:
            raise InputError(f"{self.bus.line}: built without banks, so nothing can be loaded; set loadable_g")
        if result == Result.REFUSED:
            self.host.use_rom(POLLS)
            raise InputError(f"{self.bus.line}: the core refuses the image, which is of another size; make it with "
                             "`gravcomp image --rom` of the folder that the core was built with")  # fmt: skip
        if result != Result.OK:
            raise InputError(
                f"{self.bus.line}: the image was sent, but does not come into use; does the core's clock run?"
            )
        return crc

    def configure(self, settings: Settings) -> None:
        """Write limits and times. Raises InputError for settings with which the brakes can never be released."""
        if complaint := self.host.complaint(self.identity, settings):
            raise InputError(f"{self.bus.line}: {complaint}; correct the limits")
        self.host.configure(self.identity, settings)

    def home(self, settings: Settings) -> Iterator[State]:
        """Arm homing; the state, again and again, until every axis was moved over its index by hand."""
        self.configure(settings)
        self._done(self.host.home(self.all_axes))
        self._done(self.host.tick(True))
        while (state := self.host.read()).referenced != self.all_axes:
            yield state
        yield state

    def hold(self, settings: Settings) -> Iterator[State]:
        """Release the brakes and hold; the state, again and again. The brakes are engaged when the caller stops.

        Raises InputError, with the brakes engaged, when an axis is not referenced or a fault comes.
        """
        self._check_watchdog(settings)
        self.configure(settings)
        self._done(self.host.tick(True))
        state = self.host.read()
        if missing := self.all_axes & ~state.referenced:
            raise InputError(f"{self.bus.line}: axes {_axes(missing)} have not passed their index; start `home` first")
        try:
            if self.host.release(POLLS) != Result.OK:
                raise InputError(f"{self.bus.line}: {self._faults()}")
            while True:
                self.host.kick()
                state = self.host.read()
                if state.brakes != Brakes.RUN:
                    raise InputError(f"{self.bus.line}: {self._faults()}")
                yield state
        finally:
            self.host.stop()

    def _check_watchdog(self, settings: Settings) -> None:
        """InputError when the watchdog would bite between two kicks."""
        needed_us = round(1e6 * EXCHANGES_PER_KICK * self.exchange_s())
        if needed_us > settings.watchdog_us:
            raise InputError(
                f"{self.bus.line}: watchdog_us = {settings.watchdog_us}, but the {EXCHANGES_PER_KICK} exchanges from "
                f"kick to kick take {needed_us} us on this line; raise it, or the baud"
            )

    def exchange_s(self, n: int = 10) -> float:
        """Time of an exchange of one register, mean of n."""
        start_s = self.now_s()
        for _ in range(n):
            self.bus.read(self._map["id"].address)
        return (self.now_s() - start_s) / n

    def _done(self, result: Result) -> None:
        if result != Result.OK:
            raise InputError(f"{self.bus.line}: the core does not follow; does its clock run?")

    def _faults(self) -> str:
        state = self.host.read()
        causes = [cause for cause in Cause if (state.fault | state.cause) >> cause & 1]
        outside = (f"axes {_axes(state.clamped)} stand outside of the range the core was trained for; "
                   "move them into it")  # fmt: skip
        if not causes and state.clamped:
            return f"the brakes are not released: {outside}"
        if not causes:
            return "the brakes are not released, and no fault is told; try again"
        names = ", ".join(cause.name.lower() for cause in causes)
        first = [cause for cause in causes if state.first_cause >> cause & 1] or causes
        if state.clamped and first[0] in OF_CLAMPED:
            return f"brakes engaged, faults: {names}; {outside}"
        advice = next((REMEDIES[cause] for cause in [*first, *causes] if cause in REMEDIES), "see docs/guide/safety.md")
        return f"brakes engaged, faults: {names}; {advice}"

    def selftest(self, seconds: float = 0.5) -> Iterator[Check]:
        """Check line, registers, refusals, clocks and results, with the brakes engaged throughout.

        Raises InputError when they are not. seconds: for which results are counted.
        """
        state = self.host.read()
        if state.brakes in (Brakes.RUN, Brakes.HOLDING):
            raise InputError(f"{self.bus.line}: the robot is being held; stop that first")
        yield self._check_line()
        yield self._check_register()
        yield from self._check_refusals()
        yield Check("clock of the core runs", self.host.core_runs(), f"{self.identity.clock_hz} Hz")
        yield self._check_results(seconds)
        state = self.host.read()
        yield Check("brakes are engaged", state.released == 0, Brakes(state.brakes).name.lower())

    def _check_line(self) -> Check:
        n, before = 50, self.bus.repeated
        each_s = self.exchange_s(n)
        repeated = self.bus.repeated - before
        return Check("line", repeated == 0, f"{n} exchanges, {1e3 * each_s:.1f} ms each, {repeated} repeated")

    def _check_register(self) -> Check:
        """Patterns in a register that no released brake depends on now; what it held is put back."""
        address = self._map["watchdog_clocks"].address
        kept = self.bus.read(address)
        patterns = [0x00000000, 0xFFFFFFFF, 0x55555555, 0xAAAAAAAA, 0x00FF00FF, 0x12345678]
        try:
            wrong = [word for word in patterns if self._held(address, word) != word]
        finally:
            self.bus.write(address, kept)
        return Check(
            "register holds what is written", not wrong, f"{len(patterns) - len(wrong)} of {len(patterns)} patterns"
        )

    def _held(self, address: int, word: int) -> int:
        self.bus.write(address, word)
        return self.bus.read(address)

    def _check_refusals(self) -> Iterator[Check]:
        """A register that is not there, half of one, and a write to one that is read only."""
        accesses = (
            ("read where no register is", 4, lambda: self.bus.read(NO_REGISTER)),
            ("read of half a register", 2, lambda: self.bus.read(2)),
            ("write to the identity", 4, lambda: self.bus.write(self._map["id"].address, 0)),
        )
        for name, code, access in accesses:
            try:
                access()
                found = 0
            except Refused as refused:
                found = refused.code
            yield Check(f"{name} is refused", found == code, f"exception {found}" if found else "no exception")

    def _check_results(self, seconds: float) -> Check:
        """Results per second against the tick, by this computer's clock."""
        tick, kept = (self.bus.read(self._map[name].address) for name in ("tick_clocks", "control"))
        self._done(self.host.tick(True))
        start_s, first, first_late_s = self._result_number()
        time.sleep(seconds)
        end_s, last, last_late_s = self._result_number()
        self._done(self.host.tick(bool(self._map["control"].field("tick_enable", kept))))
        found_hz = (last - first) % 2**32 / (end_s - start_s)
        expected_hz = self.identity.clock_hz / max(tick, 2)
        allowed = CLOCK_TOLERANCE + (first_late_s + last_late_s) / (end_s - start_s)
        return Check(
            "results come with the tick",
            abs(found_hz / expected_hz - 1) < allowed,
            f"{found_hz:.0f} per second, {expected_hz:.0f} expected, {100 * allowed:.1f} % allowed",
        )

    def _result_number(self) -> tuple[float, int, float]:
        """The time of a reading, s, the number of results, and by how much the time may be wrong."""
        before = time.monotonic()
        number = self.bus.read(self._map["result_number"].address)
        after = time.monotonic()
        return (before + after) / 2, number, (after - before) / 2


def load_limits(path: Path, folder: Path | str) -> Settings:
    """The Settings in a TOML file of limits, for the core of a machine folder, which tells the rest.

    Keys are the fields of Settings but axes, clock_hz, expected_weights and index_period; what each axis has of its own
    is one number for all or one per axis in brackets. A table [motion] is that of gravcomp.driver.moving. Raises
    InputError for a key that is missing, unknown, or no whole number in its range, and as load_machine does.
    """
    machine = machine_settings(folder) | {"index_period": tuple(a.index_period for a in load_machine(folder).axes)}
    table = read_limits(path)
    table.pop("motion", None)
    asked = [field for field in fields(Settings) if field.name not in machine]
    names = {field.name for field in asked}
    if unknown := sorted(set(table) - names):
        raise InputError(f"{path}: {unknown[0]}: not a limit; those are {', '.join(sorted(names))}")
    values = {}
    for field in asked:
        if field.name in table:
            n_axes = machine["axes"] if field.type == tuple[int, ...] else None
            values[field.name] = _limit(path, field.name, table[field.name], n_axes)
        elif field.name != "brake_test_us":
            raise InputError(f"{path}: {field.name} is missing; add it")
    return Settings(**values, **machine)


def read_limits(path: Path) -> dict:
    """The tables of a TOML file of limits. Raises InputError when it cannot be read."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read ({reason}); give a TOML file of limits") from None


def _limit(path: Path, name: str, value, n_axes: int | None) -> int | tuple[int, ...]:
    """A value of Settings; n_axes: of a limit that each axis has, else None."""
    low = -(2**31) if name == "index_position" else 0
    if n_axes and isinstance(value, list):
        if len(value) != n_axes or not all(_is_count(v, low) for v in value):
            raise InputError(f"{path}: {name}: need {n_axes} whole numbers in brackets, one per axis")
        return tuple(value)
    if not _is_count(value, low):
        raise InputError(f"{path}: {name}: need a whole number from {low} to {low + 2**32 - 1}")
    return (value,) * n_axes if n_axes else value


def _is_count(value, low: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and low <= value < low + 2**32


def _axes(mask: int) -> str:
    """Axes of a set, as a user counts them."""
    return ", ".join(str(axis + 1) for axis in range(mask.bit_length()) if mask >> axis & 1)
