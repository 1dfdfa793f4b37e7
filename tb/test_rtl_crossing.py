"""gc_crossing_pulse and gc_crossing_bus between unrelated clocks: nothing lost, nothing doubled, never torn."""

from dataclasses import dataclass, field

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer
from cocotb.utils import get_sim_time

from gravcomp_lab.benches.changes import value_change
from runner import simulate

STAGES = 2
MHZ = [(10, 40), (40, 10), (40, 40), (40, 40.01), (40.01, 40), (40.1, 40), (33.333, 40), (100, 7.3)]
N_WORDS = 250
# At one in two, and between the slowest clocks, a word is taken after some dozens.
OFFERS = 10_000


def start_clocks(dut, in_mhz: float, out_mhz: float, rng: np.random.Generator) -> tuple[int, int]:
    """Start both clocks with a random phase; returns their periods in fs."""
    periods = [2 * round(5e8 / mhz) for mhz in (in_mhz, out_mhz)]
    for clk, period in zip((dut.in_clk, dut.out_clk), periods, strict=True):
        cocotb.start_soon(delayed_clock(clk, period, int(rng.integers(1, period))))
    return tuple(periods)


async def delayed_clock(clk, period: int, delay: int) -> None:
    clk.value = 0
    await Timer(delay, "fs")
    Clock(clk, period, "fs").start()


@dataclass
class Traffic:
    """What went in and came out, and when (fs): the edges that took a word, changes of `held`, and arrivals."""

    sent: list[int] = field(default_factory=list)
    received: list[int] = field(default_factory=list)
    taken_fs: list[int] = field(default_factory=list)
    held_fs: list[int] = field(default_factory=list)
    arrived_fs: list[int] = field(default_factory=list)

    async def send(self, dut, words: list[int], gap: float, rng: np.random.Generator) -> None:
        """Offer the words in order; between them, and with probability gap, another word without in_valid."""
        has_data = hasattr(dut, "in_data")
        for word in words:
            for _ in range(OFFERS):
                await FallingEdge(dut.in_clk)
                offers = rng.random() >= gap
                dut.in_valid.value = int(offers)
                if has_data:
                    dut.in_data.value = word if offers else word ^ 0xFFFFFFFF
                await Timer(1, "fs")
                if offers and dut.in_ready.value == 1:
                    break
            else:
                raise AssertionError(f"not taken in {OFFERS} clocks")
            await RisingEdge(dut.in_clk)
            self.sent.append(word)
            self.taken_fs.append(round(get_sim_time("fs")))
        await FallingEdge(dut.in_clk)
        dut.in_valid.value = 0

    async def receive(self, dut) -> None:
        has_data = hasattr(dut, "out_data")
        while True:
            await FallingEdge(dut.out_clk)
            if dut.out_valid.value == 1:
                self.received.append(int(dut.out_data.value) if has_data else len(self.received))
                self.arrived_fs.append(round(get_sim_time("fs")))
            elif has_data and self.received:
                assert int(dut.out_data.value) == self.received[-1], "the word changed before it was announced"

    async def watch(self, signal) -> None:
        while True:
            await value_change(signal)
            self.held_fs.append(round(get_sim_time("fs")))


async def assert_in_step(dut) -> None:
    """What leaves is registered: it changes with the rising edge of out_clk."""
    while True:
        await value_change(dut.out_valid)
        assert dut.out_clk.value == 1


async def run(dut, mhz: tuple[float, float], gap: float, seed: int) -> tuple[Traffic, tuple[int, int]]:
    cocotb.log.info("seed %d", seed)
    rng = np.random.default_rng(seed)
    dut.in_valid.value = 0
    is_bus = hasattr(dut, "in_data")
    traffic = Traffic()
    if is_bus:
        dut.in_data.value = 0
        dut.out_rst.value = 0
    periods = start_clocks(dut, *mhz, rng)
    await Timer(4 * sum(periods), "fs")
    tasks = [cocotb.start_soon(traffic.receive(dut)), cocotb.start_soon(assert_in_step(dut))]
    if is_bus:
        tasks.append(cocotb.start_soon(traffic.watch(dut.held)))
    words = rng.integers(0, 2**32, N_WORDS).tolist() if is_bus else list(range(N_WORDS))
    await traffic.send(dut, words, gap, rng)
    await Timer(8 * sum(periods), "fs")
    for task in tasks:
        task.cancel()
    return traffic, periods


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(mhz=MHZ, gap=[0.0, 0.6])
async def every_word_arrives_once(dut, mhz, gap):
    traffic, (in_fs, out_fs) = await run(dut, mhz, gap, seed=11)
    assert traffic.received == traffic.sent
    latencies = (np.array(traffic.arrived_fs) - np.array(traffic.taken_fs)) / out_fs
    bus_clock = hasattr(dut, "out_data")  # the register behind the pulse
    print(f"MEASURED {mhz} MHz: {latencies.min():.2f} to {latencies.max():.2f} clocks of out_clk")
    assert STAGES - 1 + bus_clock <= latencies.min()
    assert latencies.max() <= STAGES + 1 + bus_clock
    if not gap:
        round_trip = (STAGES + 1) * (in_fs + out_fs) + in_fs
        assert np.diff(traffic.taken_fs).max() <= round_trip


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(mhz=MHZ)
async def held_word_is_stable_when_it_is_taken(dut, mhz):
    """Tearing needs a change near the taking edge: half a clock before it is read here at the falling edge."""
    traffic, (_, out_fs) = await run(dut, mhz, 0.0, seed=12)
    changes, takes = np.array(traffic.held_fs), np.array(traffic.arrived_fs) - out_fs // 2
    assert len(changes) > 0.9 * N_WORDS
    since = [take - changes[changes <= take].max() for take in takes]
    until = [changes[changes > take].min() - take for take in takes[:-1] if (changes > take).any()]
    print(f"MEASURED {mhz} MHz: stable {min(since) / out_fs:.2f} clocks before, {min(until) / out_fs:.2f} after")
    assert min(since) >= STAGES * out_fs - 2
    assert min(until) > 0


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def reset_clears_the_word_and_loses_no_later_one(dut):
    _, periods = await run(dut, (40, 33.333), 0.0, seed=13)
    assert dut.out_data.value != 0
    dut.out_rst.value = 1
    await Timer(2 * sum(periods), "fs")
    assert (dut.out_valid.value, dut.out_data.value) == (0, 0)
    dut.out_rst.value = 0
    later = Traffic()
    receiver = cocotb.start_soon(later.receive(dut))
    await later.send(dut, [5, 6, 7], 0.0, np.random.default_rng(14))
    await Timer(8 * sum(periods), "fs")
    receiver.cancel()
    assert later.received == [5, 6, 7]


def test_crossing_pulse_keeps_every_pulse():
    simulate("gc_crossing_pulse", "test_rtl_crossing", tests="every_word", generics={"stages_g": STAGES})


def test_crossing_bus_keeps_every_word_whole():
    simulate("gc_crossing_bus", "test_rtl_crossing", generics={"width_g": 32, "stages_g": STAGES})
