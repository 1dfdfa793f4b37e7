"""gc_biss reads a modelled encoder through its pins; what is wrong on the line is told, and no count comes of it."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from gravcomp.twin.biss import CRC_BITS, POLYNOMIAL, bits_of, crc6, frame
from gravcomp_lab.benches.stream import start
from runner import simulate

GENERICS = {"position_bits_g": 18, "half_clocks_g": 4, "start_periods_g": 8, "rest_clocks_g": 60}
TIMEOUT = 30  # clocks that the encoder waits for MA


def known(name: str) -> int:
    return int(os.environ[f"{name.upper()}_G"])


class Encoder:
    """SLO of an encoder, a clock at a time, from MA. bits: what it sends after its acknowledge. delay: of the line,
    clocks. busy: periods between acknowledge and start bit. stuck: level that the line has whatever happens."""

    def __init__(self, bits, *, delay=0, busy=1, stuck=None, returns=True):
        self.bits, self.busy, self.stuck, self.returns = bits, busy, stuck, returns
        self.line, self.ma, self.edges, self.since, self.slo = [1] * (delay + 1), 1, 0, 0, 1

    def clock(self, ma: int) -> int:
        if ma and not self.ma:
            self.edges += 1
            k = self.edges - 2 - self.busy
            # the first rising edge latches the position, the second acknowledges
            self.slo = 1 if self.edges < 2 else 0 if k < 0 or k >= len(self.bits) else self.bits[k]
        self.since = 0 if ma != self.ma else self.since + 1
        self.ma = ma
        if ma and self.since > TIMEOUT and self.edges:
            self.edges, self.slo = 0, int(self.returns)
        self.line = [*self.line[1:], self.slo]
        return self.line[0] if self.stuck is None else self.stuck


async def begin(dut) -> None:
    dut.cfg_clear.value, dut.pin_slo.value = 0, 1
    await start(dut)
    for _ in range(4):
        await FallingEdge(dut.clk)


async def read(dut, encoder: Encoder) -> int | None:
    """The count of a frame, or None; ends when MA has rested."""
    dut.in_valid.value, count = 1, None
    periods = known("position_bits") + 12 + known("start_periods")
    for _ in range(2 * known("half_clocks") * periods + known("rest_clocks") + 10):
        await FallingEdge(dut.clk)
        dut.in_valid.value = 0
        dut.pin_slo.value = encoder.clock(int(dut.pin_ma.value))
        if dut.out_valid.value == 1:
            assert count is None
            count = dut.out_count.value.to_signed()
    return count


def flags(dut) -> tuple[int, int]:
    return int(dut.sts_error.value), int(dut.out_known.value)


@cocotb.test()
@cocotb.parametrize(delay=[0, 1, 3, 4, 5, 9, 20])
async def positions_arrive_over_any_line(dut, delay):
    """Corners and random positions of the format, at delays up to several periods of MA."""
    rng, bits = np.random.default_rng(delay), known("position_bits")
    await begin(dut)
    half = 2 ** (bits - 1)
    for position in [-half, half - 1, -1, 0, 1, *rng.integers(-half, half, 8).tolist()]:
        encoder = Encoder(frame(position, bits), delay=delay, busy=int(rng.integers(1, 4)))
        assert await read(dut, encoder) == position
        assert flags(dut) == (0, 1)
        assert dut.sts_warning.value == 0


@cocotb.test()
async def every_wrong_bit_is_told(dut):
    """One bit of position, flags or CRC, and bursts of up to six: none is taken for a position."""
    bits = known("position_bits")
    position = -(2 ** (bits - 2))
    good = frame(position, bits)
    for first in range(2, len(good)):
        for burst in (0b1, 0b100001, 0b111111):
            bad = [bit ^ (burst >> k - first & 1 if 0 <= k - first < CRC_BITS else 0) for k, bit in enumerate(good)]
            await begin(dut)
            assert await read(dut, Encoder(good)) == position
            assert await read(dut, Encoder(bad)) is None
            assert flags(dut) == (1, 0)
            assert dut.out_count.value.to_signed() == position


@cocotb.test()
async def broken_stuck_and_silent_lines_are_told(dut):
    bits = known("position_bits")
    lines = {
        "open, pulled up": Encoder(frame(1, bits), stuck=1),
        "shorted": Encoder(frame(1, bits), stuck=0),
        "never starts": Encoder(frame(1, bits), busy=1000),
        "does not come back": Encoder(frame(1, bits), returns=False),
        "in error": Encoder(frame(1, bits, error=True)),
    }
    for name, encoder in lines.items():
        await begin(dut)
        if encoder.stuck is not None:
            dut.pin_slo.value = encoder.stuck
            for _ in range(3):
                await FallingEdge(dut.clk)
        assert await read(dut, encoder) is None, name
        assert flags(dut) == (1, 0), name
        # another reset than that of the entity: the next frame is good, the error stays until it is cleared
        assert await read(dut, Encoder(frame(0, bits))) == (None if not encoder.slo or encoder.stuck == 0 else 0), name


@cocotb.test()
async def error_stays_until_cleared_and_known_until_wrong(dut):
    bits = known("position_bits")
    await begin(dut)
    assert flags(dut) == (0, 0)
    await read(dut, Encoder(frame(1, bits, error=True)))
    assert await read(dut, Encoder(frame(2, bits))) == 2
    assert flags(dut) == (1, 1)
    dut.cfg_clear.value = 1
    await FallingEdge(dut.clk)
    dut.cfg_clear.value = 0
    assert flags(dut) == (0, 1)
    assert await read(dut, Encoder(frame(3, bits, warning=True))) == 3
    assert (dut.sts_warning.value, *flags(dut)) == (1, 0, 1)


@cocotb.test()
async def reset_in_a_frame_begins_anew(dut):
    bits = known("position_bits")
    for clocks in range(1, 2 * known("half_clocks") * (bits + 12), 17):
        await begin(dut)
        encoder = Encoder(frame(77, bits))
        dut.in_valid.value = 1
        for _ in range(clocks):
            await FallingEdge(dut.clk)
            dut.in_valid.value = 0
            dut.pin_slo.value = encoder.clock(int(dut.pin_ma.value))
        await begin(dut)
        assert (*flags(dut), int(dut.pin_ma.value), dut.out_count.value.to_signed()) == (0, 0, 1, 0)
        assert await read(dut, Encoder(frame(78, bits))) == 78


@cocotb.test()
async def request_in_a_frame_is_not_seen(dut):
    bits = known("position_bits")
    await begin(dut)
    encoder, counts = Encoder(frame(77, bits)), []
    dut.in_valid.value = 1
    for _ in range(2 * known("half_clocks") * (bits + 13) + 2 * known("rest_clocks")):
        await FallingEdge(dut.clk)
        dut.pin_slo.value = encoder.clock(int(dut.pin_ma.value))
        counts += [dut.out_count.value.to_signed()] * int(dut.out_valid.value)
        dut.in_valid.value = int(not counts)
    assert counts == [77]


@pytest.mark.parametrize("position_bits", [2, 18, 32])
def test_biss_reads_an_encoder(position_bits):
    tests = None if position_bits == 18 else "positions|are_told|is_told"
    simulate("gc_biss", "test_rtl_biss", generics={**GENERICS, "position_bits_g": position_bits}, tests=tests)


@pytest.mark.parametrize(
    ("generics", "message"),
    [({"position_bits_g": 1}, "need position_bits_g in 2 to 32, got 1"),
     ({"position_bits_g": 33}, "need position_bits_g in 2 to 32, got 33"),
     ({"half_clocks_g": 1}, "need half_clocks_g >= 2, got 1")],
)  # fmt: skip
def test_biss_refuses_generics(generics, message):
    with pytest.raises(AssertionError, match=f"gc_biss: {message}"):
        simulate("gc_biss", "test_rtl_biss", generics={**GENERICS, **generics})


def test_crc_is_a_remainder():
    """The data followed by their CRC is a multiple of the polynomial; every burst of six bits leaves one."""
    rng = np.random.default_rng(6)
    for _ in range(200):
        data = rng.integers(0, 2, int(rng.integers(4, 40))).tolist()
        assert crc6([*data, *bits_of(crc6(data), CRC_BITS)]) == 0
    assert all(crc6([*bits_of(burst, CRC_BITS), *[0] * n]) for burst in range(1, 2**CRC_BITS) for n in range(30))
    assert POLYNOMIAL == 1 << 6 | 1 << 1 | 1
