"""gc_adc_spi reads a modelled serial ADC through its pins: codes of every channel, scaled, and none of a wrong one.

cocotbext-spi 0.5.0 does not import with cocotb 2.1 (it wants cocotb.clock.BaseClock), so the ADC is modelled here.
"""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import corners_and_random, pack, unpack
from gravcomp.twin.adc import command, current_ua
from gravcomp_lab.benches.stream import start
from runner import simulate

MAX11125 = {"channels_g": 3, "code_bits_g": 12, "id_bits_g": 4, "half_clocks_g": 3, "gap_clocks_g": 5}
PLAIN = {**MAX11125, "channels_g": 1, "code_bits_g": 16, "id_bits_g": 0, "command_g": 0}


def known(name: str) -> int:
    return int(os.environ[f"{name.upper()}_G"])


class Adc:
    """SPI mode 3, a clock at a time. It answers with number and code of the channel that the last frame asked for, as
    MISO changes `delay` clocks after SCLK falls. lies: the number that it gives of a channel."""

    def __init__(self, codes, delay=1, lies=lambda channel: channel):
        self.codes, self.lies, self.asked, self.heard = codes, lies, 0, []
        self.miso, self.cs_n, self.sclk, self.line = 0, 1, 1, [0] * delay

    def clock(self, cs_n: int, sclk: int, mosi: int) -> int:
        if self.cs_n and not cs_n:
            assert sclk
            self.word, self.n_bits, self.reply = 0, 0, self._reply()
        if not cs_n and self.sclk and not sclk:
            self.miso, self.reply = self.reply >> 15 & 1, self.reply << 1
        if not cs_n and not self.sclk and sclk:
            self.word, self.n_bits = self.word << 1 | mosi, self.n_bits + 1
        if cs_n and not self.cs_n:
            assert (self.n_bits, sclk) == (16, 1)
            self.heard.append(self.word)
            self.asked = self.word >> 7 & 0xF
        self.cs_n, self.sclk = cs_n, sclk
        self.line = [*self.line[1:], self.miso]
        return self.line[0]

    def _reply(self) -> int:
        unused = 16 - known("id_bits") - known("code_bits")
        number = self.lies(self.asked) << 16 - known("id_bits") if known("id_bits") else 0
        return number | self.codes[self.asked] << unused


async def begin(dut, zero, scale) -> None:
    dut.cfg_zero.value, dut.cfg_scale.value, dut.pin_miso.value = pack(zero, 16), pack(scale, 24), 0
    await start(dut)
    await FallingEdge(dut.clk)


def scan_clocks() -> int:
    frame = (2 * 16 + 2) * known("half_clocks") + known("gap_clocks") + 1
    return (known("channels") + 1) * frame + 8


async def scan(dut, adc: Adc) -> list[tuple[int, int]]:
    """Channel and current of each sense_valid of a scan."""
    dut.in_valid.value, told = 1, []
    for _ in range(scan_clocks()):
        await FallingEdge(dut.clk)
        dut.in_valid.value = 0
        pins = (int(getattr(dut, f"pin_{name}").value) for name in ("cs_n", "sclk", "mosi"))
        dut.pin_miso.value = adc.clock(*pins)
        currents = unpack([int(dut.sense_current.value)], 32, known("channels"))[0]
        told += [(k, int(currents[k])) for k in range(known("channels")) if int(dut.sense_valid.value) >> k & 1]
    return told


@cocotb.test()
@cocotb.parametrize(delay=[1, 2, 3])
async def currents_of_all_channels(dut, delay):
    """Corners and random codes, zeros and scales; each channel once, in order, in the time that the header states."""
    rng, n = np.random.default_rng(delay), known("channels")
    most = 2 ** known("code_bits") - 1
    for _ in range(6):
        codes = np.where(rng.random(n) < 0.3, rng.choice([0, most], n), rng.integers(0, most, n)).tolist()
        zero = np.where(rng.random(n) < 0.3, rng.choice([0, 65535], n), rng.integers(0, 65535, n)).tolist()
        scale = corners_and_random(24, (n,), rng).tolist()
        await begin(dut, zero, scale)
        adc = Adc(codes, delay)
        expected = [(k, current_ua(codes[k], zero[k], scale[k])) for k in range(n)]
        assert await scan(dut, adc) == expected
        assert await scan(dut, adc) == expected
        base = known("command") if "COMMAND_G" in os.environ else 0x0806
        assert adc.heard == 2 * [command(k, base) for k in [*range(n), 0]]
        assert dut.sts_errors.value == 0


@cocotb.test()
async def code_of_another_channel_is_dropped_and_counted(dut):
    n = known("channels")
    if not known("id_bits"):
        return
    await begin(dut, [0] * n, [256] * n)
    codes = list(range(100, 100 + n))
    assert await scan(dut, Adc(codes)) == list(enumerate(codes))
    told = await scan(dut, Adc([5] * n, lies=lambda channel: channel ^ (channel == 1)))
    assert told == [(k, 5) for k in range(n) if k != 1]
    assert dut.sts_errors.value == 1
    assert unpack([int(dut.sense_current.value)], 32, n)[0][1] == 101  # the last good one holds


@cocotb.test()
async def reset_ends_a_scan(dut):
    n = known("channels")
    for clocks in range(1, scan_clocks(), 41):
        await begin(dut, [0] * n, [256] * n)
        adc = Adc([7] * n)
        dut.in_valid.value = 1
        for _ in range(clocks):
            await FallingEdge(dut.clk)
            dut.in_valid.value = 0
        await begin(dut, [0] * n, [256] * n)
        assert (dut.pin_cs_n.value, dut.pin_sclk.value, int(dut.sense_valid.value)) == (1, 1, 0)
        assert await scan(dut, adc) == [(k, 7) for k in range(n)]


@pytest.mark.parametrize("generics", [MAX11125, {**MAX11125, "channels_g": 8}, PLAIN])
def test_adc_is_read(generics):
    simulate("gc_adc_spi", "test_rtl_adc_spi", generics=generics)


@pytest.mark.parametrize(
    ("generics", "message"),
    [({"half_clocks_g": 2}, "need half_clocks_g >= 3, got 2"),
     ({"code_bits_g": 13}, "need code_bits_g <= 16, .* got 13, 4 and 16")],
)  # fmt: skip
def test_adc_refuses_generics(generics, message):
    with pytest.raises(AssertionError, match=f"gc_adc_spi: {message}"):
        simulate("gc_adc_spi", "test_rtl_adc_spi", generics={**MAX11125, **generics, "frame_bits_g": 16})
