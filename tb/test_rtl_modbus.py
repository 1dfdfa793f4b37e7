"""gc_modbus: answers, registers and counts are its twin's, for right, wrong, cut, merged and noisy frames."""

import itertools
import os

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from cocotbext.axi import AxiLiteBus, AxiLiteSlave

from gravcomp.twin import modbus
from gravcomp.twin.modbus import PORT, Count, ModbusSlave, SlaveError, framed
from runner import simulate

UNIT = 17
GAP, CHARACTER, BUS = 24, 5, 400  # clocks
# An answer begins before: a word costs eight clocks, and the stalls.
PATIENCE = 3000


class Registers:
    """Those on the bus: every word whose address ends in 0xC is an error; the rest keeps what is written."""

    def __init__(self):
        self.words, self.written = {}, []

    def read(self, offset: int) -> int:
        if offset % 16 == 12:
            raise SlaveError
        return self.words.get(offset, offset * 0x01010101 & 0xFFFFFFFF)

    def write(self, offset: int, word: int) -> None:
        if offset % 16 == 12:
            raise SlaveError
        self.words[offset] = word
        self.written.append((offset, word))


class Target:
    """The same registers for cocotbext-axi: whatever a target raises is SLVERR."""

    def __init__(self, registers: Registers):
        self.registers = registers

    async def read(self, address: int, length: int) -> bytes:
        assert length == 4
        return self.registers.read(address).to_bytes(4, "little")

    async def write(self, address: int, data: bytes) -> None:
        assert len(data) == 4
        self.registers.write(address, int.from_bytes(data, "little"))


class Line:
    """gc_modbus between a line of characters and registers, beside its twin."""

    _clock = None

    def __init__(self, dut, rng):
        self.dut, self.rng = dut, rng
        self.registers, self.twin = Registers(), ModbusSlave(Registers(), UNIT)

    async def start(self, is_stalled: bool) -> None:
        dut = self.dut
        if Line._clock:
            Line._clock.stop()
        Line._clock = Clock(dut.clk, 10, "ns")
        Line._clock.start(start_high=False)
        dut.rst.value = 1
        dut.rx_valid.value = dut.rx_error.value = dut.rx_receiving.value = 0
        dut.tx_ready.value = 1
        self.slave = AxiLiteSlave(AxiLiteBus.from_prefix(dut, "m_axi"), dut.clk, dut.rst, target=Target(self.registers))
        channels = (self.slave.write_if.aw_channel, self.slave.write_if.w_channel, self.slave.write_if.b_channel,
                    self.slave.read_if.ar_channel, self.slave.read_if.r_channel)  # fmt: skip
        for channel in channels:
            channel.log.setLevel("WARNING")
            if is_stalled:
                channel.set_pause_generator(self._pauses())
        for one in (self.slave.write_if, self.slave.read_if):
            one.log.setLevel("ERROR")
        await self.clocks(4)
        dut.rst.value = 0
        await self.clocks(2)

    def _pauses(self):
        return (bool(pause) for pause in itertools.cycle(self.rng.random(997) < 0.6))

    async def clocks(self, n: int) -> None:
        for _ in range(n):
            await FallingEdge(self.dut.clk)

    async def send(self, frame: bytes, *, wrong: int = -1, pause: int = 0, pause_at: int = 0) -> None:
        """The characters of a frame; the one of index wrong has an error; pause more clocks before that of pause_at."""
        dut = self.dut
        for k, byte in enumerate(frame):
            await self.clocks(pause if k == pause_at else 0)
            dut.rx_receiving.value = 1
            await self.clocks(CHARACTER)
            dut.rx_receiving.value = 0
            dut.rx_valid.value, dut.rx_data.value, dut.rx_error.value = 1, byte, int(k == wrong)
            await self.clocks(1)
            dut.rx_valid.value = 0

    async def heard(self) -> bytes | None:
        """The answer, at the pace of a line that takes a character in 1 to 9 clocks; None: none has begun in time."""
        dut, got = self.dut, bytearray()
        for _ in range(PATIENCE):
            if dut.tx_enable.value == 1:
                break
            await self.clocks(1)
        else:
            return None
        while dut.tx_enable.value == 1:
            if dut.tx_valid.value == 1:
                got.append(int(dut.tx_data.value))
                await self.clocks(1)
                dut.tx_ready.value = 0
                await self.clocks(int(self.rng.integers(1, 9)))
                dut.tx_ready.value = 1
            else:
                await self.clocks(1)
        return bytes(got)

    async def exchange(self, frame: bytes, *, wrong: int = -1) -> bytes | None:
        """The answer, which is the twin's, and so are the registers. Nothing is written before the frame's end."""
        before = len(self.registers.written)
        await self.send(frame, wrong=wrong)
        await self.clocks(GAP - 2)
        assert len(self.registers.written) == before, "written before the end"
        expected = self.twin.answer(frame, has_bad_character=0 <= wrong < len(frame))
        if expected is None:
            # No answer is waited for: what is sent too early would be seen as no answer to the next frame.
            await self.clocks(8)
            assert self.dut.tx_enable.value == 0, frame.hex()
            answer = None
        else:
            answer = await self.heard()
        assert answer == expected, (
            f"{frame.hex()}: got {answer and answer.hex()}, expected {expected and expected.hex()}"
        )
        assert self.registers.written == self.twin.bus.written, frame.hex()
        return answer

    async def counts(self) -> list[int]:
        """The port's own registers, read through it."""
        answer = await self.exchange(request(3, PORT // 2, 8))
        return [int.from_bytes(answer[k : k + 4], "big") for k in range(3, 19, 4)]


def request(function: int, first: int, quantity: int, data: bytes = b"", *, read: tuple[int, int] = ()) -> bytes:
    """A frame for UNIT; read: first and quantity of what function 23 reads."""
    runs = [*read, first, quantity]
    tail = bytes([len(data)]) + data if function in (16, 23) else b""
    return framed(bytes([UNIT, function]) + b"".join(v.to_bytes(2, "big") for v in runs) + tail)


def right(rng) -> bytes:
    """A frame that can be carried out, unless it meets an error of the bus: some stop after a few words."""
    function = int(rng.choice([3, 4, 16, 23]))
    limit = {16: modbus.MOST_WRITTEN, 23: modbus.MOST_OF_BOTH}.get(function, modbus.MOST_READ)
    words = int(rng.integers(1, limit // 2 + 1)) if rng.random() < 0.2 else int(rng.integers(1, 4))
    first = 2 * int(rng.integers(0, modbus.REGISTERS // 2 - words + 1))
    if function in (3, 4):
        return request(function, first, 2 * words)
    read = (2 * int(rng.integers(0, 900)), 2 * int(rng.integers(1, 4))) if function == 23 else ()
    return request(function, first, 2 * words, rng.bytes(4 * words), read=read)


def wrong_request(rng) -> bytes:
    """A frame with a right CRC that is refused, of another unit, or with random bytes."""
    data = rng.bytes(4)
    word = (16, 0, 2, data)
    candidates = [
        request(3, 1, 2), request(3, 0, 1), request(4, 0, 0), request(3, 0, 126), request(3, 0, 65535),
        request(3, modbus.REGISTERS, 2), request(3, 65534, 4), request(3, modbus.REGISTERS - 2, 4),
        request(16, 1, 2, data), request(16, 0, 1, data[:2]), request(16, 0, 4, data), request(16, 0, 2, data + data),
        request(16, modbus.REGISTERS, 2, data), request(16, 0, 124, bytes(248)), request(16, 2, 32770, data),
        request(23, 0, 2, data, read=(1, 2)), request(23, 3, 2, data, read=(0, 2)),
        request(23, 0, 3, data, read=(0, 2)),
        request(23, 0, 2, data, read=(0, 0)), request(23, 0, 122, bytes(244), read=(0, 2)),
        request(23, 0, 2, data, read=(2050, 8)), request(23, 1, 2, data, read=(0, 0)),
        framed(bytes([UNIT, 3, 0, 0, 0, 2, 0])), framed(bytes([UNIT, 3])), framed(bytes([UNIT, 16])),
        framed(bytes([UNIT, 23, 0, 0])), framed(bytes([UNIT, 6, 0, 0, 0, 0])),
        framed(bytes([UNIT, int(rng.integers(0, 256))]) + rng.bytes(int(rng.integers(0, 20)))),
        framed(bytes([0]) + request(*word)[1:-2]), framed(bytes([UNIT + 1]) + request(*word)[1:-2]),
    ]  # fmt: skip
    return candidates[rng.integers(len(candidates))]


def damaged(rng) -> bytes:
    """What noise makes of a right frame: bits, a cut, characters lost or too many, two frames without a gap."""
    frame = bytearray(right(rng))
    kind = rng.integers(6)
    if kind == 0:
        frame[rng.integers(len(frame))] ^= 1 << rng.integers(8)
    elif kind == 1:
        del frame[rng.integers(1, len(frame)) :]
    elif kind == 2:
        del frame[rng.integers(len(frame))]
    elif kind == 3:
        frame += rng.bytes(int(rng.integers(1, 4)))
    elif kind == 4:
        frame += right(rng)
    else:
        frame = bytearray(framed(bytes([UNIT, 16]) + rng.bytes(260)))
    return bytes(frame)


@cocotb.test()
@cocotb.parametrize(is_stalled=[False, True])
async def frames(dut, is_stalled):
    seed = 61 + is_stalled
    rng = np.random.default_rng(seed)
    cocotb.log.info("seed %d", seed)
    line = Line(dut, rng)
    await line.start(is_stalled)
    answers = []
    for _ in range(int(os.environ["FRAMES"])):
        kind = rng.random()
        if kind < 0.45:
            answers.append(await line.exchange(right(rng)))
        elif kind < 0.75:
            answers.append(await line.exchange(wrong_request(rng)))
        elif kind < 0.95:
            answers.append(await line.exchange(damaged(rng)))
        else:
            frame = right(rng)
            answers.append(await line.exchange(frame, wrong=int(rng.integers(len(frame)))))
    before = list(line.twin.counts)
    assert await line.counts() == before
    assert {answer[2] for answer in answers if answer and answer[1] & 0x80} == {1, 2, 3, 4}
    assert {answer[1] for answer in answers if answer and not answer[1] & 0x80} == {3, 4, 16, 23}
    assert before[Count.DROPPED] > 10
    assert before[Count.WRITTEN] > 30


@cocotb.test()
async def every_refusal(dut):
    """Each frame of wrong_request, in its order, and the longest that are right."""
    line = Line(dut, np.random.default_rng(63))
    await line.start(False)

    class InTurn:  # a generator that draws the k-th candidate
        def __init__(self, k):
            self.k, self.rng = k, np.random.default_rng(k)

        def integers(self, *bounds):
            return self.k if len(bounds) == 1 else self.rng.integers(*bounds)

        def bytes(self, n):
            return self.rng.bytes(n)

    for k in range(30):
        await line.exchange(wrong_request(InTurn(k)))
    data = np.random.default_rng(64).bytes(8 * 30)
    for frame in (request(3, 0x100, 124), request(16, 0x100, 122, data + data[:4]),
                  request(23, 0x100, 120, data, read=(0x200, 124))):  # fmt: skip
        assert (await line.exchange(frame))[1:3] == bytes([frame[1] | 0x80, 4])
    before = list(line.twin.counts)
    assert await line.counts() == before


@cocotb.test()
@cocotb.parametrize(idle=[GAP - 1, GAP])
async def gap_ends_a_frame(dut, idle):
    """A silence of GAP clocks cuts a frame in two, both dropped; one clock less does not."""
    line = Line(dut, np.random.default_rng(65))
    await line.start(False)
    frame = request(16, 0x20, 2, b"\x12\x34\x56\x78")
    await line.send(frame, pause=idle, pause_at=5)
    answer = await line.heard()
    if idle < GAP:
        assert answer == line.twin.answer(frame)
        assert line.registers.written == [(0x40, 0x12345678)]
    else:
        assert answer is None
        assert line.registers.written == []
        line.twin.counts[Count.DROPPED] = 2
        assert await line.counts() == [0, 2, 0, 0]


@cocotb.test()
async def false_starts_do_not_end_the_silence(dut):
    """A start bit that was none within the gap: the silence goes on where it was."""
    line = Line(dut, np.random.default_rng(66))
    await line.start(False)
    frame = request(3, 0, 2)
    await line.send(frame)
    await line.clocks(GAP - 4)
    dut.rx_receiving.value = 1
    await line.clocks(3 * GAP)
    assert dut.tx_enable.value == 0
    dut.rx_receiving.value = 0
    await line.clocks(10)
    assert await line.heard() == line.twin.answer(frame)


@cocotb.test()
async def what_comes_during_an_answer_is_not_heard(dut):
    line = Line(dut, np.random.default_rng(67))
    await line.start(False)
    frame, late = request(3, 0, 2), request(16, 0x20, 2, bytes(4))
    await line.send(frame)
    heard = cocotb.start_soon(line.heard())
    await line.clocks(GAP + 8)
    await line.send(late[:5])
    assert not heard.done()
    assert await heard == line.twin.answer(frame)
    await line.send(late[5:])  # the rest of it: a frame with a wrong CRC
    assert await line.heard() is None
    line.twin.counts[Count.DROPPED] = 1
    assert await line.counts() == [1, 1, 0, 0]
    assert line.registers.written == []
    assert await line.exchange(frame) is not None


@cocotb.test()
@cocotb.parametrize(kind=["write", "read"])
async def silent_bus_is_answered_for(dut, kind):
    """Exception 04 in BUS clocks, again at once while that lasts, the other kind as ever; then all is well."""
    line = Line(dut, np.random.default_rng(69))
    await line.start(False)
    silent, other = request(16, 0x20, 4, b"\x12\x34\x56\x78" * 2), request(3, 0x40, 2)
    one = line.slave.write_if.b_channel if kind == "write" else line.slave.read_if.r_channel
    if kind == "read":
        silent, other = other, silent
    one.pause = True
    refused = framed(bytes([UNIT, silent[1] | 0x80, modbus.DEVICE_FAILURE]))
    for _ in range(2):
        await line.send(silent)
        assert await line.heard() == refused
    await line.send(other)
    assert await line.heard() == line.twin.answer(other)
    one.pause = False
    await line.clocks(20)
    assert len(line.registers.written) == (1 if kind == "write" else 2), "the word that was asked for stands"
    line.twin.counts = [3, 0, len(line.registers.written), 2]
    line.twin.bus.written, line.twin.bus.words = list(line.registers.written), dict(line.registers.words)
    assert await line.exchange(silent) is not None
    before = list(line.twin.counts)
    assert await line.counts() == before


@cocotb.test()
async def reset_forgets_the_frame_and_the_counts(dut):
    line = Line(dut, np.random.default_rng(68))
    await line.start(False)
    frame = request(16, 0x20, 2, bytes(4))
    await line.exchange(frame)
    await line.send(frame[:5])
    dut.rst.value = 1
    await line.clocks(2)
    dut.rst.value = 0
    await line.clocks(2)
    await line.send(frame[5:])
    assert await line.heard() is None
    line.twin.counts = [0, 1, 0, 0]
    assert await line.counts() == [0, 1, 0, 0]


@pytest.mark.slow
def test_modbus_equals_its_twin():
    simulate(
        "gc_modbus",
        "test_rtl_modbus",
        generics={"unit_g": UNIT, "gap_clocks_g": GAP, "bus_clocks_g": BUS},
        environment={"FRAMES": "200"},
    )
