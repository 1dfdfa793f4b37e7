"""gc_uart: equal to its twin at every clock, on lines with noise, breaks and a baud that is off; what it sends, too."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer, with_timeout
from cocotbext.uart import UartSink, UartSource

from gravcomp.twin.encoder import synchronizer
from gravcomp.twin.uart import Parity, UartConfig, line_bits, receive, send
from playback import assert_equal, play
from runner import simulate


def config() -> UartConfig:
    """That of the entity under test."""
    return UartConfig(int(os.environ["CLOCK_HZ"]), int(os.environ["BAUD"]), Parity(int(os.environ["PARITY"])))


def line(rng, uart: UartConfig, n_characters: int, *, off: float = 0.0, noise: float = 0.0, gap_bits: int = 3):
    """Characters, and the levels of a sender whose baud is off, with pulses in a part of the clocks."""
    data = rng.integers(0, 256, n_characters)
    bits = [1] * 4
    for byte in data:
        bits += line_bits(int(byte), uart.parity) + [1] * int(rng.integers(0, gap_bits + 1))
    edges = np.ceil(np.arange(len(bits) + 13) * uart.clock_hz / (uart.baud * (1 + off))).astype(int)
    levels = np.repeat([*bits, *[1] * 12], np.diff(edges))
    return data, np.where(rng.random(len(levels)) < noise, 1 - levels, levels)


async def play_line(dut, levels: np.ndarray, rst: np.ndarray | None = None):
    """What the entity receives from these levels, and its twin."""
    rst = np.zeros(len(levels), np.int64) if rst is None else rst
    outputs = ("out_valid", "out_data", "out_error")
    dut.in_valid.value = 0
    recorded = await play(dut, {"pin_rx": levels, "rst": rst}, outputs)
    known, synced = synchronizer(rst, levels, 2)
    return recorded, receive(known & synced, config())


def assert_same(recorded: dict[str, np.ndarray], characters: list) -> None:
    got = [(int(k), int(recorded["out_data"][k]) & 255, bool(recorded["out_error"][k]))
           for k in np.flatnonzero(recorded["out_valid"])]  # fmt: skip
    assert got == [(c.clock, c.data, c.error) for c in characters]


@cocotb.test()
@cocotb.parametrize(part=[-0.99, 0.0, 0.99])
async def understands_a_baud_that_is_off(dut, part):
    """By so much of the tolerance, characters back to back."""
    uart, rng = config(), np.random.default_rng(51)
    slow, fast = uart.tolerance
    data, levels = line(rng, uart, 50, off=part * (fast if part > 0 else slow), gap_bits=0)
    recorded, characters = await play_line(dut, levels)
    assert_same(recorded, characters)
    assert [c.data for c in characters] == data.tolist()
    assert not any(c.error for c in characters)


@cocotb.test()
async def short_pulses_change_nothing(dut):
    """One clock wrong in every eighth of a bit or so, never two that meet two samples."""
    uart, rng = config(), np.random.default_rng(52)
    data, levels = line(rng, uart, 30, gap_bits=0)
    apart = uart.clocks(4, 8)
    wrong = np.arange(uart.clocks(6), len(levels), apart)
    inside = _away_from_edges(levels, wrong)
    levels[inside] ^= 1
    assert len(inside) > 100
    recorded, characters = await play_line(dut, levels)
    assert_same(recorded, characters)
    assert [c.data for c in characters if not c.error] == data.tolist()


def _away_from_edges(levels: np.ndarray, clocks: np.ndarray) -> np.ndarray:
    """Those of the clocks that lie in a low level, where no pulse looks like a start, two clocks from its ends."""
    return clocks[[levels[k - 2 : k + 3].sum() == 0 for k in clocks]]


@cocotb.test()
@cocotb.parametrize(noise=[0.003, 0.03, 0.3])
async def noise_is_received_as_the_twin_does(dut, noise):
    rng = np.random.default_rng(53)
    cocotb.log.info("seed 53")
    _, levels = line(rng, config(), 40, noise=noise)
    recorded, characters = await play_line(dut, levels)
    assert_same(recorded, characters)
    assert any(c.error for c in characters) or noise < 0.3


@cocotb.test()
@cocotb.parametrize(off=[-0.2, 0.2])
async def wrong_baud_is_told(dut, off):
    rng = np.random.default_rng(54)
    _, levels = line(rng, config(), 40, off=off)
    recorded, characters = await play_line(dut, levels)
    assert_same(recorded, characters)
    assert sum(c.error for c in characters) >= len(characters) // 4 > 0


@cocotb.test()
async def break_is_one_error_and_reset_forgets(dut):
    uart, rng = config(), np.random.default_rng(55)
    data, levels = line(rng, uart, 6)
    pause = np.zeros(uart.clocks(40), np.int64)
    both = np.concatenate([levels, pause, levels])
    rst = np.zeros(len(both), np.int64)
    rst[len(levels) + len(pause) + uart.clocks(9)] = 1  # within the first character after the break
    recorded, characters = await play_line(dut, both)
    assert_same(recorded, characters)
    assert [c.data for c in characters] == [*data, 0, *data]
    assert [c.error for c in characters] == [False] * 6 + [True] + [False] * 6
    recorded, _ = await play_line(dut, both, rst)
    at = np.flatnonzero(recorded["out_valid"])
    first = uart.clocks(4 + uart.bits) + len(levels) + len(pause)
    assert len(at[at < first - uart.clocks(uart.bits)]) == 7
    assert not any(abs(at - first) < uart.clocks(1)), "a character went through a reset"


@cocotb.test()
async def sends_as_its_twin(dut):
    uart, rng = config(), np.random.default_rng(56)
    data = [0x00, 0xFF, 0x55, 0x80, *rng.integers(0, 256, 12).tolist()]
    n_clocks = (len(data) + 1) * (uart.clocks(uart.bits) + 4)
    valid, offered = np.zeros(n_clocks, np.int64), np.zeros(n_clocks, np.int64)
    levels, ready = np.ones(n_clocks, np.int64), np.ones(n_clocks, np.int64)
    clock = 3
    for byte in data:
        character = send(byte, uart)
        valid[clock : clock + 1 + len(character)] = 1  # offered until the next one: taken once
        offered[clock] = byte
        offered[clock + 1 : clock + 1 + len(character)] = 255 - byte
        levels[clock + 1 : clock + 1 + len(character)] = character
        ready[clock + 1 : clock + 1 + len(character)] = 0
        clock += 1 + len(character) + int(rng.integers(0, 3))
        valid[clock - 1] = 0 if clock and ready[clock - 1] else valid[clock - 1]
    dut.pin_rx.value = 1
    recorded = await play(dut, {"in_valid": valid, "in_data": offered}, ["pin_tx", "in_ready"])
    assert_equal(recorded, {"pin_tx": levels, "in_ready": ready})


@cocotb.test()
async def talks_to_another_uart(dut):
    """cocotbext-uart, which knows no parity, on both pins, both ways at once."""
    uart = config()
    for old in ("in_valid", "rst"):
        getattr(dut, old).value = 0
    Clock(dut.clk, round(1e12 / uart.clock_hz) // 2 * 2, "ps").start(start_high=False)
    source = UartSource(dut.pin_rx, baud=uart.baud, bits=8)
    sink = UartSink(dut.pin_tx, baud=uart.baud, bits=8)
    sent, got = bytes(range(7, 250, 23)), bytearray()
    await Timer(20_000_000_000 // uart.baud + 1, "ns")
    await source.write(sent)

    async def echo():
        while len(got) < len(sent):
            await FallingEdge(dut.clk)
            if dut.out_valid.value == 1:
                assert dut.out_error.value == 0
                got.append(int(dut.out_data.value))
                while dut.in_ready.value == 0:
                    await FallingEdge(dut.clk)
                dut.in_data.value, dut.in_valid.value = got[-1], 1
                await FallingEdge(dut.clk)
                dut.in_valid.value = 0

    await with_timeout(echo(), len(sent) * 20 * 10**9 // uart.baud, "ns")
    assert bytes(got) == sent
    echoed = bytearray()
    while len(echoed) < len(sent):
        echoed += await with_timeout(sink.read(), 30 * 10**9 // uart.baud, "ns")
    assert bytes(echoed) == sent


@pytest.mark.parametrize(
    ("clock_hz", "baud", "parity"),
    [
        (40_000_000, 3_000_000, 0),
        pytest.param(24_000_000, 3_000_000, 2, marks=pytest.mark.slow),
        pytest.param(2_000_000, 115_200, 1, marks=pytest.mark.slow),
    ],
)
def test_uart_equals_its_twin(clock_hz, baud, parity):
    simulate(
        "gc_uart",
        "test_rtl_uart",
        generics={"clock_hz_g": clock_hz, "baud_g": baud, "parity_g": parity},
        environment={"CLOCK_HZ": str(clock_hz), "BAUD": str(baud), "PARITY": str(parity)},
        tests=None if parity == Parity.NONE else r"\.(?!talks)\w+(/|$)",
    )
