"""gc_recorder holds, word by word, the records of its twin: in every mode, with every loss counted and flagged."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import corners_and_random, pack
from gravcomp.twin.recorder import LOST_BEFORE, STALE, Mode, Recorder, words_of
from gravcomp_lab.benches.stream import start
from runner import simulate

WAIT = 4  # clocks after the last word
PORTS = ("count", "period", "command", "force")


class Bench:
    """The entity beside its twin; every call does the same to both."""

    def __init__(self, dut, rng: np.random.Generator):
        self.dut, self.rng, self.number = dut, rng, 0
        self.n_axes, self.address_bits = int(os.environ["AXES_G"]), int(os.environ["ADDRESS_BITS_G"])
        self.twin = Recorder(self.n_axes, self.address_bits, Mode.OFF)

    async def begin(self, mode: Mode, **settings) -> None:
        """Reset, then the mode with its settings: ticks, mean, before."""
        await self.reset()
        await self.set_mode(mode, **settings)

    async def reset(self) -> None:
        for name in ("cfg_mode", "cfg_ticks", "cfg_mean", "cfg_before", "in_trigger", "sense_valid", "in_drop"):
            getattr(self.dut, name).value = 0
        self.dut.read_addr.value = 0
        await start(self.dut)

    async def set_mode(self, mode: Mode, **settings) -> None:
        self.twin = Recorder(self.n_axes, self.address_bits, mode, **settings)
        self.dut.cfg_mode.value = int(mode)
        for name in ("ticks", "mean", "before"):
            getattr(self.dut, f"cfg_{name}").value = int(getattr(self.twin, name))
        await FallingEdge(self.dut.clk)
        for name in ("ticks", "mean", "before"):  # taken with the mode, and only then
            getattr(self.dut, f"cfg_{name}").value = 1

    async def sense(self, axes) -> None:
        currents = corners_and_random(32, (self.n_axes,), self.rng)
        self.dut.sense_valid.value, self.dut.sense_current.value = sum(1 << k for k in axes), pack(currents, 32)
        await FallingEdge(self.dut.clk)
        self.dut.sense_valid.value = 0
        for k in axes:
            self.twin.sense(k, int(currents[k]))

    async def tick(self, n: int = 1) -> None:
        for _ in range(n):
            values = {name: corners_and_random(32, (self.n_axes,), self.rng) for name in PORTS}
            status, self.number = int(self.rng.integers(0, 2**30)), self.number + 1
            for name in PORTS:
                getattr(self.dut, f"in_{name}").value = pack(values[name], 32)
            self.dut.in_tick.value, self.dut.in_status.value, self.dut.in_valid.value = self.number, status, 1
            await FallingEdge(self.dut.clk)
            self.dut.in_valid.value = 0
            for _ in range(words_of(self.n_axes)):
                await FallingEdge(self.dut.clk)
            for name in (*PORTS, "tick", "status"):  # it has to hold no longer
                getattr(self.dut, f"in_{name}").value = 0
            for _ in range(WAIT - 1):
                await FallingEdge(self.dut.clk)
            axes = [{name: int(values[name][k]) for name in PORTS} for k in range(self.n_axes)]
            self.twin.tick(self.number, status, axes)
            self.check()

    async def trigger(self) -> None:
        self.dut.in_trigger.value = 1
        await FallingEdge(self.dut.clk)
        self.dut.in_trigger.value = 0
        self.twin.trigger()

    async def drop(self) -> None:
        self.dut.in_drop.value = 1
        await FallingEdge(self.dut.clk)
        self.dut.in_drop.value = 0
        self.twin.drop()
        self.check()

    def check(self) -> None:
        twin, dut = self.twin, self.dut
        got = [int(getattr(dut, f"sts_{name}").value) for name in ("records", "lost", "triggered", "done")]
        assert got == [len(twin.records), twin.lost, twin.triggered, twin.done]

    async def read(self) -> list[list[int]]:
        """All records, read twice: reading changes nothing."""
        words, n = [], words_of(self.n_axes)
        for address in [*range(n * len(self.twin.records))] * 2:
            self.dut.read_addr.value = address
            await FallingEdge(self.dut.clk)
            words.append(int(self.dut.read_word.value))
        half = len(words) // 2
        assert words[:half] == words[half:]
        return [words[k : k + n] for k in range(0, half, n)]

    async def compare(self) -> None:
        assert await self.read() == self.twin.records


@cocotb.test()
@cocotb.parametrize(mean=[False, True], ticks=[0, 1, 3])
async def free_running_equals_twin(dut, mean, ticks):
    """Records are taken out now and then; those that find no room are counted, and the next one says so."""
    bench = Bench(dut, np.random.default_rng(10 + ticks))
    await bench.begin(Mode.FREE, mean=mean, ticks=ticks)
    for _ in range(12):
        if bench.rng.random() < 0.6:
            await bench.sense(bench.rng.permutation(bench.n_axes)[: bench.rng.integers(1, bench.n_axes + 1)].tolist())
        await bench.tick(2**ticks)
        while bench.rng.random() < 0.4:
            await bench.drop()
        await bench.compare()
    await bench.tick((bench.twin.capacity + 1) * 2**ticks)
    assert bench.twin.lost > 0
    await bench.drop()
    await bench.tick(2**ticks)
    await bench.compare()
    assert bench.twin.records[-1][1] & LOST_BEFORE


@cocotb.test()
async def single_shot_ends_when_full_and_keeps_what_it_has(dut):
    bench = Bench(dut, np.random.default_rng(1))
    await bench.begin(Mode.SINGLE)
    await bench.tick(bench.twin.capacity + 2)
    assert (bench.twin.done, bench.twin.lost) == (True, 0)
    await bench.compare()
    await bench.drop()
    await bench.tick(2)
    await bench.compare()


@cocotb.test()
async def fault_keeps_what_came_before_it(dut):
    """For every number of records before it, none and more than fit included, at every fill of the ring."""
    bench = Bench(dut, np.random.default_rng(2))
    capacity = 2**bench.address_bits // words_of(bench.n_axes)
    for before in (0, 1, capacity - 1, capacity, capacity + 3):
        for n_ticks in (0, 1, capacity, 2 * capacity + 1):
            await bench.begin(Mode.FAULT, before=before)
            await bench.tick(n_ticks)
            await bench.drop()  # is not done while waiting
            await bench.trigger()
            await bench.tick(capacity + 1)
            assert bench.twin.done
            await bench.compare()
            kept = min(n_ticks, before, capacity)
            assert [words[0] for words in bench.twin.records][:kept] == [
                *range(bench.number - capacity - kept, bench.number - capacity)
            ]


@cocotb.test()
async def off_records_nothing_and_keeps_what_was(dut):
    bench = Bench(dut, np.random.default_rng(3))
    await bench.reset()
    await bench.tick(3)
    assert not bench.twin.records
    await bench.set_mode(Mode.FREE)
    await bench.tick(2)
    kept, bench.dut.cfg_mode.value = bench.twin.records, 0
    await FallingEdge(dut.clk)
    assert await bench.read() == kept
    bench.twin.mode = Mode.OFF
    await bench.tick(2)
    assert await bench.read() == kept
    await bench.set_mode(Mode.FREE)
    bench.check()
    await bench.tick(1)
    await bench.compare()


@cocotb.test()
async def change_of_mode_and_reset_drop_the_record_under_way(dut):
    bench = Bench(dut, np.random.default_rng(4))
    for clocks in range(1, words_of(bench.n_axes) + WAIT):
        await bench.begin(Mode.SINGLE)
        dut.in_valid.value = 1
        for _ in range(clocks):
            await FallingEdge(dut.clk)
            dut.in_valid.value = 0
        await bench.set_mode(Mode.FREE)
        bench.check()
        await bench.tick(1)
        await bench.compare()


@cocotb.test()
async def currents_are_told_to_be_old(dut):
    bench = Bench(dut, np.random.default_rng(5))
    await bench.begin(Mode.FREE)
    await bench.tick(1)
    for axis in range(bench.n_axes):
        assert bench.twin.records[-1][1] & STALE
        await bench.drop()
        await bench.sense(range(axis + 1))
        await bench.tick(1)
        await bench.compare()
    assert not bench.twin.records[-1][1] & STALE


@pytest.mark.parametrize(("axes", "address_bits"), [(1, 3), (3, 6), (8, 7)])
def test_recorder_equals_twin(axes, address_bits):
    simulate("gc_recorder", "test_rtl_recorder", generics={"axes_g": axes, "address_bits_g": address_bits})


@pytest.mark.parametrize(
    ("generics", "message"),
    [({"axes_g": 9, "address_bits_g": 10}, "need axes_g <= 8, got 9"),
     ({"axes_g": 3, "address_bits_g": 4}, r"need 2\*\*address_bits_g >= 17, got address_bits_g = 4")],
)  # fmt: skip
def test_recorder_refuses_generics(generics, message):
    with pytest.raises(AssertionError, match=f"gc_recorder: {message}"):
        simulate("gc_recorder", "test_rtl_recorder", generics=generics)
