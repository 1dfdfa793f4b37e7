"""Bit-true, cycle-accurate model of gc_uart. Arrays over clocks are as in gravcomp.twin.encoder."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

SAMPLES = (2, 3, 4)  # eighths of a bit after its beginning


class Parity(IntEnum):
    """The generic parity_g."""

    NONE = 0
    ODD = 1
    EVEN = 2


@dataclass(frozen=True)
class UartConfig:
    """The generics of gc_uart, without their suffix."""

    clock_hz: int = 40_000_000
    baud: int = 115_200
    parity: Parity = Parity.NONE

    @property
    def bits(self) -> int:
        """Bits of a character, start and stop included."""
        return 10 if self.parity == Parity.NONE else 11

    @property
    def tolerance(self) -> tuple[float, float]:
        """Fractions by which a sender may be slow and fast.

        Slow: two of the three samples of the last bit come after its beginning. Fast: the stop bit is decided, with its
        start seen and each sample taken up to a clock late, before the next character begins.
        """
        late = 2 * self.baud / self.clock_hz
        return 3 / 8 / self.bits, (1 / 2 - late) / (self.bits - 1 / 2 + late)

    def clocks(self, bits: int, parts: int = 1) -> int:
        """Clocks after which so many parts of a bit are over, rounded up: ceil(bits clock_hz / (parts baud))."""
        return -(-bits * self.clock_hz // (parts * self.baud))


@dataclass(frozen=True)
class Character:
    """What comes in the clock with out_valid."""

    clock: int
    data: int
    error: bool


def line_bits(data: int, parity: Parity = Parity.NONE) -> list[int]:
    """The levels of a character on the line, start bit first."""
    bits = [data >> k & 1 for k in range(8)]
    check = [] if parity == Parity.NONE else [sum(bits) % 2 ^ (parity == Parity.ODD)]
    return [0, *bits, *check, 1]


def send(data: int, config: UartConfig) -> np.ndarray:
    """Levels of pin_tx from the clock after the one that takes data, until in_ready is high again."""
    ends = [config.clocks(k) for k in range(config.bits + 1)]
    return np.repeat(line_bits(data, config.parity), np.diff(ends))


def receive(level: np.ndarray, config: UartConfig) -> list[Character]:
    """The characters in the levels behind the synchroniser, of a line that was low before."""
    characters, clock, was_high = [], 0, False
    while clock < len(level):
        if was_high and level[clock] == 0:
            clock, was_high, character = _character(level, clock, config)
            characters += [] if character is None else [character]
        else:
            was_high = bool(level[clock])
        clock += 1
    return characters


def _character(level: np.ndarray, start: int, config: UartConfig) -> tuple[int, bool, Character | None]:
    """What starts there: clock and level of its last bit, and the character; None: not one, or not all of it."""
    bits = []
    for k in range(config.bits):
        samples = [start + config.clocks(8 * k + eighth, 8) for eighth in SAMPLES]
        if samples[-1] >= len(level):
            return len(level), False, None
        bits.append(int(level[samples].sum() >= 2))
        if bits[0] == 1:
            return samples[-1], True, None
    data = sum(bit << k for k, bit in enumerate(bits[1:9]))
    return samples[-1], bool(bits[-1]), Character(samples[-1] + 1, data, bits != line_bits(data, config.parity))
