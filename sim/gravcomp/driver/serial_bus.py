"""The registers of gc_serial_system over its serial line: a Bus for the driver, by Modbus RTU.

The 32-bit register at byte offset A is the holding registers A/2, its high half, and A/2 + 1. Frames are pymodbus's. A
frame without an answer is sent again: a read as it is, a write only if the port, which counts the words that it wrote,
did not count these. So every word is written once, however many answers are lost.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from gravcomp.errors import InputError, optional
from gravcomp.twin.modbus import MOST_READ, Count

PARITIES = {"none": "N", "odd": "O", "even": "E"}
EXCEPTIONS = {
    1: "it does not know that function",
    2: "there are no such registers",
    3: "it does not take so many registers",
    4: "the core refused the access",
}


@dataclass(frozen=True)
class Line:
    """A serial line: device or URL of pyserial; baud, parity and unit as built (gc_serial_system's generics).

    timeout_s: longest time until an answer has come. attempts: how often a frame is sent until it is given up.
    """

    port: str
    baud: int = 115_200
    parity: str = "none"
    unit: int = 1
    timeout_s: float = 0.3
    attempts: int = 5

    def __str__(self) -> str:
        letter = PARITIES[self.parity]
        return f"{self.port}: unit {self.unit} at {self.baud} baud, 8{letter}1"


class Refused(InputError):
    """The port answered with an exception. code: 1 to 4."""

    def __init__(self, message: str, code: int):
        super().__init__(message)
        self.code = code


class Trouble(IntEnum):
    """What came instead of an answer."""

    SILENCE = 0
    DAMAGE = 1


class SerialBus:
    """A gravcomp.driver.host.Bus on a line. repeated: frames sent again; sent: all of them.

    Raises InputError when the port cannot be opened, when nothing answers, when answers are damaged attempts times in a
    row, and Refused when an access is.
    """

    def __init__(self, line: Line):
        self.line, self.sent, self.repeated = line, 0, 0
        self._received, self._answered = 0, False
        self._client = _open(line, self._trace)
        # Words that the port has counted; None: unknown, since a write was refused or interrupted.
        self._written: int | None = None
        try:
            self.count(Count.WRITTEN)
        except InputError:
            self.close()
            raise

    def close(self) -> None:
        self._client.close()

    def __enter__(self) -> "SerialBus":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def read(self, offset: int) -> int:
        return self.read_run(offset, 1)[0]

    def read_run(self, offset: int, n_words: int) -> list[int]:
        """So many registers from a byte offset on."""
        words = []
        while len(words) < n_words:
            n = min(n_words - len(words), MOST_READ // 2)
            first, where = offset // 2 + 2 * len(words), f"a read of {n} at 0x{offset + 4 * len(words):03X}"
            words += _words(self._persist(lambda n=n, first=first: self._read(first, n), where))
        return words

    def write(self, offset: int, word: int) -> None:
        self.write_run(offset, [word])

    def write_run(self, offset: int, words: Sequence[int]) -> None:
        """Registers from a byte offset on, at most 61; those before one that is refused are written."""
        halves = [half for word in words for half in (word >> 16 & 0xFFFF, word & 0xFFFF)]
        where = f"a write of {len(words)} at 0x{offset:03X}"
        before = self.count(Count.WRITTEN) if self._written is None else self._written
        self._written = None
        request = self._client.write_registers
        self._persist(
            lambda: self._answer(lambda: request(offset // 2, halves, device_id=self.line.unit), where),
            where,
            lambda: self._stands(before, len(words), where),
        )
        self._written = _wrapped(before + len(words))

    def _stands(self, before: int, n_words: int, where: str) -> bool:
        """Whether n_words were written since the port had counted before: all of them or none, else Refused."""
        written = self.count(Count.WRITTEN)
        if written not in (before, _wrapped(before + n_words)):
            raise Refused(f"{self.line}: {where}: {EXCEPTIONS[4]}", 4)
        return written != before

    def count(self, count: Count) -> int:
        """One of the port's own registers."""
        return self.read(count.offset)

    def _read(self, first: int, n_words: int) -> list[int]:
        where = f"a read of {n_words} at 0x{2 * first:03X}"
        request = self._client.read_holding_registers
        return self._answer(lambda: request(first, count=2 * n_words, device_id=self.line.unit), where).registers

    def _persist(self, attempt, where: str, has_come=lambda: False):
        """What an attempt returns, or True once an attempt without an answer turns out to have come through."""
        troubles = []
        for _ in range(self.line.attempts):
            self.repeated += bool(troubles)
            try:
                return attempt()
            except _NoAnswer as trouble:
                troubles.append(trouble.kind)
            if has_come():
                return True
        raise InputError(f"{self.line}: {self._complaint(troubles, where)}")

    def _complaint(self, troubles: list[Trouble], where: str) -> str:
        if Trouble.DAMAGE in troubles:
            return (
                f"{where}: damaged answers, {len(troubles)} attempts; is it --baud and --parity of the core? If so, "
                "look for noise: shorten or shield the cable, or build with a lower baud"
            )
        if self._answered:
            return f"{where}: no answer any more, {len(troubles)} attempts; check cable and power"
        return (
            f"nothing answers, {len(troubles)} attempts; check cable and power, and that --baud, --parity and --unit "
            "are those that the core was built with"
        )

    def _answer(self, request, where: str):
        """The answer to a request. Raises _NoAnswer, Refused, and InputError when the port is gone."""
        exceptions = optional("pymodbus.exceptions", "pymodbus", "a board")
        self.sent += 1
        self._received = 0
        try:
            answer = request()
        except exceptions.ConnectionException:
            raise InputError(f"{self.line}: the port is gone; plug it in again and start anew") from None
        except exceptions.ModbusException:
            raise _NoAnswer(Trouble.DAMAGE if self._received else Trouble.SILENCE) from None
        self._answered = True
        if answer.isError():
            code = answer.exception_code
            raise Refused(f"{self.line}: {where}: {EXCEPTIONS.get(code, f'exception {code}')}", code)
        return answer

    def _trace(self, is_sent: bool, packet: bytes) -> bytes:
        self._received += 0 if is_sent else len(packet)
        return packet


class _NoAnswer(Exception):
    def __init__(self, kind: Trouble):
        self.kind = kind


def _open(line: Line, trace):
    """pymodbus's client of a line."""
    client = optional("pymodbus.client", "pymodbus", "a board")
    serial = optional("serial", "pyserial", "a board")
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # every complaint is ours
    try:
        serial.serial_for_url(line.port, baudrate=line.baud, exclusive=True).close()
    except (OSError, ValueError) as error:  # pyserial's own is an OSError
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise InputError(f"{line.port}: cannot be opened ({reason}); {_ports()}") from None
    opened = client.ModbusSerialClient(
        line.port,
        baudrate=line.baud,
        parity=PARITIES[line.parity],
        timeout=line.timeout_s,
        retries=0,
        trace_packet=trace,
    )
    if not opened.connect():
        raise InputError(f"{line.port}: cannot be opened with {line.baud} baud, parity {line.parity}; {_ports()}")
    return opened


def _ports() -> str:
    """The serial ports of this computer, for a message."""
    from serial.tools.list_ports import comports

    names = sorted(port.device for port in comports())
    return f"ports of this computer: {', '.join(names)}" if names else "this computer has no serial port; plug it in"


def _words(halves: Sequence[int]) -> list[int]:
    return [high << 16 | low for high, low in zip(halves[::2], halves[1::2], strict=True)]


def _wrapped(count: int) -> int:
    return count % 2**32
