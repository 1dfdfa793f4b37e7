"""Bit-true model of gc_modbus: what a frame does to the registers, and what is answered.

Source of the frames: MODBUS Application Protocol V1.1b3, MODBUS over Serial Line V1.02.
"""

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol

READ_HOLDING, READ_INPUT, WRITE, WRITE_AND_READ = 3, 4, 16, 23
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, DEVICE_FAILURE = 1, 2, 3, 4
REGISTERS = 2056  # of 16 bits, those of the port included
MOST_READ, MOST_WRITTEN, MOST_OF_BOTH = 124, 123, 121
SHORTEST, LONGEST = 4, 256  # frames, bytes
PORT = 0x1000  # byte offset of the port's own registers


class Count(IntEnum):
    """The port's own registers, in their order."""

    ANSWERED = 0
    DROPPED = 1
    WRITTEN = 2
    EXCEPTIONS = 3

    @property
    def offset(self) -> int:
        """Byte offset."""
        return PORT + 4 * self


class SlaveError(RuntimeError):
    """The bus answers with another response than OKAY."""


class Bus(Protocol):
    """32-bit registers at byte offsets below 4096. Both raise SlaveError."""

    def read(self, offset: int) -> int: ...

    def write(self, offset: int, word: int) -> None: ...


def crc16(data: bytes) -> int:
    """CRC-16 of Modbus: polynomial 0xA001 (reflected), start 0xFFFF; a frame ends with it, low byte first."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def framed(body: bytes) -> bytes:
    """The body with its CRC."""
    return body + crc16(body).to_bytes(2, "little")


@dataclass
class ModbusSlave:
    """gc_modbus on a bus."""

    bus: Bus
    unit: int = 1
    counts: list[int] = field(default_factory=lambda: [0] * len(Count))

    def answer(self, frame: bytes, *, has_bad_character: bool = False) -> bytes | None:
        """The answer to what came between two gaps; None: no answer."""
        if has_bad_character or not SHORTEST <= len(frame) <= LONGEST or crc16(frame):
            self.counts[Count.DROPPED] += 1
            return None
        if frame[0] != self.unit:
            return None
        try:
            body = self._carry_out(frame)
        except _Refusal as refusal:
            body = bytes([frame[1] | 0x80, refusal.code])
            self.counts[Count.EXCEPTIONS] += 1
        self.counts[Count.ANSWERED] += 1
        return framed(bytes([self.unit]) + body)

    def _carry_out(self, frame: bytes) -> bytes:
        """The answer without unit and CRC."""
        function = frame[1]
        first, quantity, second, written = (int.from_bytes(frame[k : k + 2], "big") for k in (2, 4, 6, 8))
        if function in (READ_HOLDING, READ_INPUT):
            _check(len(frame) == 8, (first, quantity, MOST_READ))
            return self._read(function, first, quantity)
        if function == WRITE:
            data = frame[7:-2]
            _check(len(frame) >= 9 and len(data) == frame[6] == 2 * quantity, (first, quantity, MOST_WRITTEN))
            self._write(first, data)
            return frame[1:6]
        if function == WRITE_AND_READ:
            data = frame[11:-2]
            is_whole = len(frame) >= 13 and len(data) == frame[10] == 2 * written
            _check(is_whole, (first, quantity, MOST_READ), (second, written, MOST_OF_BOTH))
            self._write(second, data)
            return self._read(function, first, quantity)
        raise _Refusal(ILLEGAL_FUNCTION)

    def _read(self, function: int, first: int, quantity: int) -> bytes:
        words = [self._read_word(2 * k) for k in range(first, first + quantity, 2)]
        return bytes([function, 2 * quantity]) + b"".join(word.to_bytes(4, "big") for word in words)

    def _read_word(self, offset: int) -> int:
        if offset >= PORT:
            return self.counts[(offset - PORT) // 4]
        try:
            return self.bus.read(offset)
        except SlaveError:
            raise _Refusal(DEVICE_FAILURE) from None

    def _write(self, first: int, data: bytes) -> None:
        for k in range(0, len(data), 4):
            offset = 2 * first + k
            if offset >= PORT:
                raise _Refusal(DEVICE_FAILURE)
            try:
                self.bus.write(offset, int.from_bytes(data[k : k + 4], "big"))
            except SlaveError:
                raise _Refusal(DEVICE_FAILURE) from None
            self.counts[Count.WRITTEN] += 1


class _Refusal(Exception):
    def __init__(self, code: int):
        self.code = code


def _check(is_whole: bool, *runs: tuple[int, int, int]) -> None:
    """Refuse a frame of a wrong length, or a run (first, quantity, most) that is too long, empty, odd or beyond."""
    if not is_whole or any(not 1 <= quantity <= most for _, quantity, most in runs):
        raise _Refusal(ILLEGAL_VALUE)
    if any(first % 2 or quantity % 2 or first + quantity > REGISTERS for first, quantity, _ in runs):
        raise _Refusal(ILLEGAL_ADDRESS)
