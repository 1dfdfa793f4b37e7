"""Moves and records on a board behind a serial line: `gravcomp board PORT move` and `record`, for Python.

    with Board(Line("/dev/ttyUSB0")) as board:
        mover = Mover(board, load_limits(path, folder), load_motion(path, folder))
        for state in mover.go([(1000, -2000, 0)], move_s=2.0, hold_s=1.0):
            print(state.position)
    print(measured_csv(mover.records(), load_machine(folder), mover.tick_s))

The servo of the core acts on the robot; the host sends targets, takes records and kicks the watchdog.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import fields
from pathlib import Path

from gravcomp.driver.board import POLLS, Board, read_limits
from gravcomp.driver.host import Result, Settings, State
from gravcomp.driver.motion import Motion, MotionSettings, MotionState, is_there
from gravcomp.errors import InputError
from gravcomp.facts import State as Brakes
from gravcomp.logs.records import Records, records_of
from gravcomp.robot.machine import load_machine
from gravcomp.twin.recorder import Mode
from gravcomp.twin.servo import gains_of
from gravcomp.twin.setpoint import ACCELERATION_FRACTION, SPEED_FRACTION, rate_of, ticks_of

# Exchanges from one kick to the next are those of Board.hold; records are taken in as many frames as fit between two.
RECORDS_AT_ONCE = 6
EXCHANGES_PER_ROUND = 40
MOST_TICKS = 15  # of a record, as a power of two
_STATE = 7  # bits of a record's status
_ALL = 2**16  # records: more than any ring holds
# Keys of the table [motion] of a file of limits.
PER_AXIS = (
    "stiffness_ua_per_count",
    "integral_ua_per_count_s",
    "damping_ua_s_per_count",
    "servo_limit_ua",
    "following_counts",
    "speed_counts_per_s",
    "acceleration_counts_per_s2",
)
FILTER = "filter"
SPEED_FEED = "speed_feed_forward"  # the only one that may be missing: the setpoint's speed is not fed forward then


class Mover:
    """A board whose core has gc_motion, with its limits and gains. tick_s: from one inference to the next.

    Raises InputError when the core was built without.
    """

    def __init__(self, board: Board, limits: Settings, gains: MotionSettings):
        if not is_there(board.bus):
            raise InputError(f"{board.bus.line}: its core neither moves nor records; build it with motion_g")
        self.board, self.limits, self.gains = board, limits, gains
        self.motion = Motion(board.bus, board.identity.axes)
        self.tick_s, self.lost = limits.tick_us * 1e-6, 0
        self._words: list[int] = []

    def records(self) -> Records:
        """All records taken since the last go began, of the time with the brakes released."""
        records = records_of(self._words, self.board.identity.axes)
        held = records.status & _STATE == Brakes.RUN
        return Records(**{field.name: getattr(records, field.name)[held] for field in fields(Records)})

    def taken(self) -> list[int]:
        """Words of the records since taken was called last."""
        words, self._words = self._words, []
        return words

    def go(self, targets: Sequence[Sequence[int]], move_s: float, hold_s: float) -> Iterator[State]:
        """Release the brakes, move to each target (counts per axis) and hold there; the state, again and again.

        move_s: of each move; longer where a limit needs it. hold_s: at each target, and where it begins. Records are
        taken throughout. The brakes are engaged at the end, and whatever ends it. Raises InputError as Board.hold does,
        and when a target is out of range or a move is refused.
        """
        self.check(targets)
        self.motion.configure(self.gains)
        self._words = []
        states = self.board.hold(self.limits)
        try:
            yield next(states)
            self.begin_records(self._ticks_of_line())
            yield from self.hold(states, hold_s)
            for target in targets:
                yield from self.move(states, target, move_s)
                yield from self.hold(states, hold_s)
        finally:
            states.close()
        self._words += self.motion.take(_ALL)
        self.lost = self.motion.record_status().lost

    def _ticks_of_line(self) -> int:
        """Ticks of a record, as a power of two, so that the line can bring them all."""
        round_s = EXCHANGES_PER_ROUND * self.board.exchange_s(5)
        return self.power_of_ticks(round_s / RECORDS_AT_ONCE)

    def power_of_ticks(self, seconds: float) -> int:
        """The power of two of ticks that are so long at least, if a record can be."""
        return min(math.ceil(math.log2(max(seconds / self.tick_s, 1.0))), MOST_TICKS)

    def begin_records(self, ticks: int) -> None:
        """One record per 2**ticks ticks, their means, from now on."""
        self.board.host.kick()
        result = self.motion.record(Mode.FREE, POLLS, mean=ticks > 0, ticks=ticks)
        if result != Result.OK:
            raise InputError(f"{self.board.bus.line}: the recorder does not begin; does the core's clock run?")

    def hold(self, states: Iterator[State], seconds: float) -> Iterator[State]:
        """Hold for so long; states are those of Board.hold."""
        end_s = self.board.now_s() + seconds
        while self.board.now_s() < end_s:
            yield self.round(states)

    def move(self, states: Iterator[State], target: Sequence[int], seconds: float) -> Iterator[State]:
        """Move to a target and be there; states are those of Board.hold. Raises InputError when that is refused."""
        self.board.host.kick()
        result = self.motion.move(tuple(target), max(round(seconds / self.tick_s), 2), POLLS)
        if result == Result.TIMEOUT:
            raise InputError(f"{self.board.bus.line}: the core does not take a move; does its clock run?")
        while not (state := self._motion_state()).ready:
            yield self.round(states)
        yield self.round(states)  # it says so, if a fault was what ended the move
        if state.refused:
            raise InputError(f"{self.board.bus.line}: speed or acceleration of an axis are too small for the move to "
                             f"{_listed(target)}; raise speed_counts_per_s or acceleration_counts_per_s2")  # fmt: skip

    def duration_s(self, start: Sequence[int], target: Sequence[int], seconds: float) -> float:
        """What the core makes of a move in so many seconds: longer where a limit of an axis needs it. Infinite where
        none keeps them."""
        spans, gains = [b - a for a, b in zip(start, target, strict=True)], self.gains
        rate = rate_of(round(seconds / self.tick_s), spans, gains.speed_max, gains.acceleration_max)
        return ticks_of(rate) * self.tick_s if rate else math.inf

    def _motion_state(self) -> MotionState:
        self.board.host.kick()
        return self.motion.read()

    def round(self, states: Iterator[State]) -> State:
        """The state, after a kick, and the records that there are."""
        state = next(states)
        self.board.host.kick()
        self._words += self.motion.take(RECORDS_AT_ONCE)
        return state

    def check(self, targets: Sequence[Sequence[int]]) -> None:
        """InputError when a target is not a count per axis within the range that the window allows."""
        identity, margin = self.board.identity, self.limits.margin_counts
        for target in targets:
            if len(target) != identity.axes:
                raise InputError(f"target {_listed(target)}: {len(target)} values; give one for each of "
                                 f"{identity.axes} axes")  # fmt: skip
            for axis, count in enumerate(target):
                low, high = identity.trained_low[axis] - margin[axis], identity.trained_high[axis] + margin[axis]
                if not low <= count <= high:
                    raise InputError(f"target {_listed(target)}: axis {axis + 1} can go from {low} to {high} counts")


def load_motion(path: Path, folder: Path | str) -> MotionSettings:
    """Gains and limits of the table [motion] of a file of limits, for the core of a machine folder.

    Stiffness in uA per count, integral in uA per count and second, damping in uA per count/s of a speed filtered
    over 2**filter ticks, which with speed_feed_forward is what it is ahead of the setpoint's; limits in uA, counts,
    counts/s and counts/s^2. What each axis has of its own is one number for all, or one per axis in brackets. Raises
    InputError for what is missing, unknown or out of range.
    """
    table, n_axes = read_limits(path), load_machine(folder).n_axes
    values = table.get("motion")
    if not isinstance(values, dict):
        raise InputError(f"{path}: no table [motion]; add it with {', '.join((*PER_AXIS, FILTER))}")
    if wrong := sorted((set(values) - {SPEED_FEED}) ^ {*PER_AXIS, FILTER}):
        known = wrong[0] in (*PER_AXIS, FILTER)
        raise InputError(f"{path}: [motion] {wrong[0]}: " + ("is missing; add it" if known else "is no key of it"))
    if not (isinstance(values[FILTER], int) and 0 <= values[FILTER] <= 15):
        raise InputError(f"{path}: [motion] {FILTER}: need a whole number from 0 to 15")
    feeds = values.get(SPEED_FEED, False)
    if not isinstance(feeds, bool):
        raise InputError(f"{path}: [motion] {SPEED_FEED}: need true or false")
    tick_s = table.get("tick_us", 0) * 1e-6
    columns = {name: _per_axis(path, name, values[name], n_axes) for name in PER_AXIS}
    axes = [_axis(path, dict(zip(PER_AXIS, row, strict=True)), values[FILTER], tick_s)
            for row in zip(*columns.values(), strict=True)]  # fmt: skip
    return MotionSettings(values[FILTER], int(feeds), *(tuple(column) for column in zip(*axes, strict=True)))


def _axis(path: Path, values: dict[str, float], filter_: int, tick_s: float) -> tuple[int, ...]:
    """The registers of an axis, in the order of MotionSettings."""
    try:
        gains = gains_of(*(values[name] for name in PER_AXIS[:3]), tick_s, filter_, values["servo_limit_ua"])
    except (ValueError, ZeroDivisionError) as error:
        raise InputError(f"{path}: [motion] {error}; lower it, or check tick_us") from None
    rows = {
        "servo_limit_ua": (gains.limit, 0, 2**31 - 1),
        "following_counts": (round(values["following_counts"]), 0, 2**32 - 1),
        "speed_counts_per_s": (round(values["speed_counts_per_s"] * tick_s * 2**SPEED_FRACTION), 1, 2**32 - 1),
        "acceleration_counts_per_s2": (
            round(values["acceleration_counts_per_s2"] * tick_s**2 * 2**ACCELERATION_FRACTION), 1, 2**32 - 1,
        ),
    }  # fmt: skip
    for name, (word, low, high) in rows.items():
        if not low <= word <= high:
            raise InputError(f"{path}: [motion] {name}: {values[name]:g} is too {'small' if word < low else 'large'}")
    return gains.proportional, gains.integral, gains.derivative, *(word for word, *_ in rows.values())


def _per_axis(path: Path, name: str, value, n_axes: int) -> list[float]:
    values = value if isinstance(value, list) else [value] * n_axes
    if len(values) != n_axes or not all(_is_number(v) for v in values):
        raise InputError(f"{path}: [motion] {name}: need a number from 0 on, or {n_axes} of them in brackets")
    return values


def _is_number(value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and value >= 0


def _listed(target: Sequence[int]) -> str:
    return " ".join(map(str, target))
