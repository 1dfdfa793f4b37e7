"""Twin of gc_recorder, a tick at a time: which records it holds, word by word. gc_recorder.vhd has the layout."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

FIELDS = ("count", "period", "sense", "command", "force")
AVERAGED = ("count", "sense", "command", "force")
LOST_BEFORE, STALE = 1 << 31, 1 << 30  # bits of a record's second word


class Mode(IntEnum):
    """What becomes of a record that finds the ring full."""

    OFF = 0
    FREE = 1
    SINGLE = 2
    FAULT = 3


def words_of(n_axes: int) -> int:
    """Words of a record."""
    return 2 + len(FIELDS) * n_axes


@dataclass
class Recorder:
    """gc_recorder after it left the mode off: settings, then state. Words are unsigned, the oldest record first."""

    n_axes: int
    address_bits: int
    mode: Mode
    ticks: int = 0
    mean: bool = False
    before: int = 0
    records: list[list[int]] = field(default_factory=list)
    lost: int = 0
    triggered: bool = False
    done: bool = False

    def __post_init__(self) -> None:
        self.capacity = 2**self.address_bits // words_of(self.n_axes)
        self.sensed = [0] * self.n_axes
        self._unknown, self._gap, self._group = set(range(self.n_axes)), False, []

    @property
    def _waits(self) -> bool:
        return self.mode == Mode.FAULT and not self.triggered

    def sense(self, axis: int, current_ua: int) -> None:
        """A measured current."""
        self.sensed[axis] = current_ua
        self._unknown.discard(axis)

    def trigger(self) -> None:
        """in_trigger in a clock."""
        self.triggered |= self.mode == Mode.FAULT

    def drop(self) -> None:
        """in_drop for a clock."""
        if self.records and not self._waits:
            del self.records[0]

    def tick(self, number: int, status: int, axes: Sequence[dict[str, int]]) -> None:
        """A tick: axes hold count, period, command and force of each."""
        if self.mode == Mode.OFF or self.done:
            return
        self._group.append([{**values, "sense": ua} for values, ua in zip(axes, self.sensed, strict=True)])
        if len(self._group) < 2**self.ticks:
            return
        group, self._group = self._group, []
        if not self._has_place():
            return
        flags = (LOST_BEFORE if self._gap else 0) | (STALE if self._unknown else 0)
        self._gap, self._unknown = False, set(range(self.n_axes))
        values = [self._value([tick[i] for tick in group], name) for i in range(self.n_axes) for name in FIELDS]
        self.records.append([word % 2**32 for word in (number, flags | status, *values)])
        self.done = self.mode != Mode.FREE and not self._waits and len(self.records) == self.capacity

    def _value(self, ticks: list[dict[str, int]], name: str) -> int:
        if not self.mean or name not in AVERAGED:
            return ticks[-1][name]
        return sum(tick[name] for tick in ticks) + len(ticks) // 2 >> self.ticks

    def _has_place(self) -> bool:
        is_full = len(self.records) == self.capacity
        if self._waits:
            if self.before and (is_full or len(self.records) >= self.before):
                del self.records[0]
            return self.before > 0
        if is_full and self.mode == Mode.FREE:
            self.lost, self._gap = self.lost + 1, True
        elif is_full:
            self.done = True
        return not is_full
