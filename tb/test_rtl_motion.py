"""Setpoints, servo, drive and recorder in a loop with three masses: release, move, hand-over, fault, without a jump."""

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, Timer

from codes import pack, unpack
from gravcomp.logs.records import records_of
from gravcomp.twin.recorder import Mode, words_of
from gravcomp.twin.servo import gains_of
from gravcomp.twin.setpoint import path
from gravcomp_lab.benches.stream import start
from runner import BENCHES, simulate

N = 3
TICK_S, TICK_CLOCKS, CLOCK_NS = 1e-3, 72, 10
MASS_KG, N_PER_A, M_PER_COUNT = np.array([20.0, 12.0, 16.0]), 45.0, 1e-6
LOAD_N = np.array([60.0, -35.0, 80.0])
SLEW_UA, LIMIT_UA, ASTRAY = 400_000, 5_000_000, 3000
FREE = 2**32 - 1


def gains():
    """Poles at 15 Hz: P, I and D of a mass, by axis."""
    omega, ua = 2 * np.pi * 15, MASS_KG * M_PER_COUNT / N_PER_A * 1e6
    return [gains_of(3 * omega**2 * m, omega**3 * m, 3 * omega * m, TICK_S, 1, LIMIT_UA) for m in ua]


class Loop:
    """The bench and three masses; every tick keeps what was commanded. feed_n: what the core holds to be the load."""

    def __init__(self, dut, feed_n=LOAD_N):
        self.dut, self.feed_n, self.x, self.v = dut, np.asarray(feed_n), np.zeros(N), np.zeros(N)
        self.braked, self.tick_number = True, 0
        self.commands, self.corrections, self.errors, self.setpoints = [], [], [], []

    @property
    def count(self) -> np.ndarray:
        return np.floor(self.x / M_PER_COUNT).astype(np.int64)

    def read(self, name: str) -> np.ndarray:
        return unpack([int(getattr(self.dut, name).value)], 32, N)[0]

    async def begin(self) -> None:
        dut = self.dut
        for name in ("run", "feed_valid", "move_valid", "cfg_mode", "cfg_before", "read_addr", "in_tick"):
            getattr(dut, name).value = 0
        for name in ("proportional", "integral", "derivative"):
            getattr(dut, f"cfg_{name}").value = pack([getattr(g, name) for g in gains()], 32)
        dut.cfg_filter.value, dut.cfg_speed_feed.value = gains()[0].filter, 0
        dut.cfg_astray.value = pack([ASTRAY] * N, 32)
        for name, value in {"cfg_limit": LIMIT_UA, "drive_limit": LIMIT_UA, "drive_slew": SLEW_UA}.items():
            getattr(dut, name).value = pack([value] * N, 31)
        dut.cfg_speed.value = dut.cfg_acceleration.value = pack([FREE] * N, 32)
        dut.in_count.value, dut.feed_current.value = pack(self.count, 32), 0
        await start(dut)
        await FallingEdge(dut.clk)

    async def ticks(self, n: int) -> None:
        for _ in range(n):
            await self._tick()

    async def _tick(self) -> None:
        dut, self.tick_number = self.dut, self.tick_number + 1
        dut.in_count.value, dut.in_tick.value, dut.in_valid.value = pack(self.count, 32), self.tick_number, 1
        dut.feed_current.value = pack(np.rint(self.feed_n / N_PER_A * 1e6), 32)
        await self._clocks(1)
        dut.in_valid.value = 0
        await self._clocks(TICK_CLOCKS // 2)
        dut.feed_valid.value = 1
        await self._clocks(1)
        dut.feed_valid.value = 0
        await self._clocks(TICK_CLOCKS // 2)
        self.commands.append(self.read("out_current"))
        self.corrections.append(self.read("sts_correction"))
        self.setpoints.append(self.read("out_setpoint"))
        self.errors.append(self.setpoints[-1] - self.count)
        force_n = self.commands[-1] * 1e-6 * N_PER_A - LOAD_N
        for _ in range(10 * (not self.braked)):
            self.v = self.v + force_n / MASS_KG * TICK_S / 10
            self.x = self.x + self.v * TICK_S / 10

    async def _clocks(self, n: int) -> None:
        """From falling edge to falling edge, without a step of Python at each."""
        await Timer(n * CLOCK_NS - CLOCK_NS // 2, "ns")
        await FallingEdge(self.dut.clk)

    async def release(self) -> None:
        """The motors take the load against the brakes, then those open."""
        self.dut.run.value = 1
        await self.ticks(15)
        self.braked = False

    async def move(self, target, ticks) -> None:
        dut = self.dut
        dut.move_target.value, dut.move_ticks.value, dut.move_valid.value = pack(target, 32), ticks, 1
        await FallingEdge(dut.clk)
        dut.move_valid.value = 0

    def largest_step(self) -> float:
        return np.abs(np.diff(self.commands, axis=0)).max()


@cocotb.test()
async def release_with_the_right_feed_forward_is_a_ramp_and_then_still(dut):
    loop = Loop(dut)
    await loop.begin()
    await loop.ticks(3)
    await loop.release()
    await loop.ticks(60)
    assert not np.any(loop.commands[:3])
    assert loop.largest_step() <= SLEW_UA
    assert not np.any(loop.corrections[:18])  # nothing to correct while the brakes hold
    assert np.abs(loop.errors).max() <= 2
    np.testing.assert_allclose(np.mean(loop.commands[-40:], axis=0) * 1e-6 * N_PER_A, LOAD_N, atol=1.0)


@cocotb.test()
async def servo_finds_what_the_feed_forward_does_not_know(dut):
    """Four fifths of the load are known. The rest ends in the correction; when the core learns it, that goes back."""
    loop = Loop(dut, 0.8 * LOAD_N)
    await loop.begin()
    await loop.release()
    await loop.ticks(250)
    assert np.abs(loop.errors[-100:]).max() <= 3
    missing_n = np.mean(loop.corrections[-100:], axis=0) * 1e-6 * N_PER_A
    np.testing.assert_allclose(missing_n, 0.2 * LOAD_N, rtol=0.05)
    loop.feed_n = LOAD_N  # the image with the cure is swapped in while it holds
    await loop.ticks(250)
    assert loop.largest_step() <= SLEW_UA
    assert np.abs(loop.errors[-100:]).max() <= 3
    left_n = np.mean(loop.corrections[-100:], axis=0) * 1e-6 * N_PER_A
    assert (np.abs(left_n) <= 0.02 * np.abs(LOAD_N)).all()


@cocotb.test()
async def move_is_followed_and_begins_without_a_jump(dut):
    """Setpoints are those of the twin; no step of the correction when a target comes; all arrive together."""
    loop, target, ticks = Loop(dut), np.array([4000, -2500, 1200]), 300
    await loop.begin()
    await loop.release()
    await loop.ticks(50)
    still = np.abs(np.diff(loop.corrections[-30:], axis=0)).max(axis=0)
    rest, began = loop.setpoints[-1], len(loop.corrections)
    await loop.move(target, ticks)
    await loop.ticks(ticks + 100)
    first = np.abs(np.diff(loop.corrections[began - 1 : began + 5], axis=0)).max(axis=0)
    per_count = np.array([g.proportional for g in gains()]) / 2**12
    assert (first <= still + 2 * per_count + 1).all()
    expected = path(rest.tolist(), target.tolist(), 2**32 // ticks)
    moving = np.array(loop.setpoints[began:])
    begins = int(np.flatnonzero((moving != rest).any(axis=1))[0])
    shown = moving[begins : begins + 200]
    offset = next(k for k, row in enumerate(expected) if (np.array(row) == shown[0]).all())
    np.testing.assert_array_equal(shown, expected[offset : offset + 200])
    assert loop.largest_step() <= SLEW_UA
    assert np.abs(loop.errors[began:]).max() < ASTRAY
    assert np.abs(loop.count - target).max() <= 3


@cocotb.test()
async def blocked_axis_is_astray_and_a_fault_forgets_everything(dut):
    """An axis that is held while its setpoint goes on; then safety takes run away, and everything starts anew."""
    loop = Loop(dut)
    await loop.begin()
    dut.cfg_mode.value, dut.cfg_before.value = int(Mode.FAULT), 6
    await FallingEdge(dut.clk)
    dut.run.value = 1
    await FallingEdge(dut.clk)
    dut.cfg_mode.value = 0
    await FallingEdge(dut.clk)
    dut.cfg_mode.value = int(Mode.FAULT)  # armed while it runs: the trigger is a fault
    await loop.release()
    loop.braked = True  # a jam
    await loop.move([20_000, 0, 0], 60)
    for _ in range(80):
        await loop.ticks(1)
        # a tick compares the setpoint of the tick before
        assert int(dut.out_astray.value) == (abs(loop.setpoints[-2][0] - loop.count[0]) > ASTRAY)
        if int(dut.out_astray.value):
            break
    assert int(dut.out_astray.value) == 1
    before = np.array(loop.commands[-6:])
    dut.run.value = 0
    await FallingEdge(dut.clk)
    assert not loop.read("out_current").any()
    assert not loop.read("sts_correction").any()
    np.testing.assert_array_equal(loop.read("out_setpoint"), loop.count)
    n = words_of(N)
    words = []
    for address in range(n * int(dut.sts_records.value)):
        dut.read_addr.value = address
        await FallingEdge(dut.clk)
        words.append(int(dut.read_word.value))
    np.testing.assert_array_equal(records_of(words, N).command, before)
    await loop.ticks(5)
    assert not np.any(loop.commands[-5:])
    await loop.release()
    assert not np.any(loop.corrections[-15:])
    await loop.ticks(40)
    assert np.abs(loop.errors[-40:]).max() <= 2


def test_motion_in_a_loop_with_masses():
    simulate("gc_motion_bench", "test_rtl_motion", extra_sources=(BENCHES / "gc_motion_bench.vhd",))
