"""What one wrong bit does in each register of gc_clock_monitor, gc_brake_test, gc_brake_feedback and gc_bus_side."""

from collections.abc import AsyncIterator

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from flips import Register, registers, simulate_flips
from test_rtl_brake_test import LIMIT, N_AXES, PHASES
from test_rtl_clock_monitor import STAGES, Clocks

# Of gc_clock_monitor: a round trip is shorter in clocks of either side.
CLOCK_LIMIT, MHZ = 24, [(10, 40), (40, 40.01), (40, 10)]
ALL = (1 << N_AXES) - 1
AXI_INPUTS = (
    "awaddr",
    "awprot",
    "awvalid",
    "wdata",
    "wstrb",
    "wvalid",
    "bready",
    "araddr",
    "arprot",
    "arvalid",
    "rready",
)
# A wrong one lasts a clock and is made anew from what is watched: a phase is shorter, or the fault is told at once.
MADE_ANEW = {"expired", "out_failed", "stage", "stages", "filled", "out_upset"}


async def clocks(dut, n: int) -> None:
    for _ in range(n):
        await FallingEdge(dut.clk)


async def assert_told(dut, register: Register, bit: int, seed: int) -> None:
    """A bit that is wrong after a number of clocks drawn by seed, in which none is told, is told one clock later."""
    for _ in range(int(np.random.default_rng(seed).integers(2, PHASES * (LIMIT + 2)))):
        assert dut.upset.value == 0, "no bit was wrong"
        await FallingEdge(dut.clk)
    register.flip(bit)
    await FallingEdge(dut.clk)
    assert dut.upset.value == 1, f"{register} {bit}"


def watched(dut) -> list[tuple[Register, int]]:
    """All bits of registers that keep what was written to them."""
    return [(r, bit) for r in registers(dut) if r.name not in MADE_ANEW for bit in range(r.bits)]


@cocotb.test()
async def wrong_bit_in_the_test_of_the_brakes_is_told(dut):
    """Whose turn it is, phase, time and parity."""
    dut.rst.value, dut.in_feedback.value, dut.cfg_clocks.value = 0, 0, LIMIT
    Clock(dut.clk, 10, "ns").start(start_high=False)
    for seed, (register, bit) in enumerate(watched(dut)):
        dut.rst.value, dut.in_start.value = 1, 0
        await clocks(dut, 3)
        dut.rst.value, dut.in_start.value = 0, 1
        await assert_told(dut, register, bit, seed)


@cocotb.test()
async def wrong_bit_in_the_read_back_is_told(dut):
    """Of an axis that does not do as told."""
    dut.brake_fed.value, dut.cfg_clocks.value = 0, LIMIT
    Clock(dut.clk, 10, "ns").start(start_high=False)
    for seed, (register, bit) in enumerate(watched(dut)):
        dut.rst.value, dut.in_released.value = 1, 0
        await clocks(dut, 6)
        dut.rst.value, dut.in_released.value = 0, ALL
        await assert_told(dut, register, bit, seed)


@cocotb.test()
async def no_wrong_bit_of_the_host_s_side_loads_anything(dut):
    """The loader is locked. What goes out with a wrong bit has the wrong parity; settings that move have theirs."""
    for handle in [handle for handle in dut if handle._name.startswith("in_")]:
        handle.value = 0
    for name in AXI_INPUTS:
        getattr(dut, f"s_axi_{name}").value = 0
    Clock(dut.clk, 10, "ns").start(start_high=False)
    n_told = 0
    for register, bit in [(r, bit) for r in registers(dut) for bit in range(r.bits)]:
        dut.rst.value, dut.out_ready.value = 1, 0
        await clocks(dut, 2)
        dut.rst.value = 0
        await clocks(dut, 3)
        register.flip(bit)
        for _ in range(4):
            await FallingEdge(dut.clk)
            load, commands = int(dut.out_settings_load.value), int(dut.out_settings_commands.value)
            is_told = (load.bit_count() + commands.bit_count()) % 2 != dut.out_settings_once_parity.value
            assert not load or is_told, f"{register} {bit}"
            n_told += is_told
    assert n_told


async def seen_after_flips(dut, mhz: tuple[float, float], stands: str, seed: int) -> AsyncIterator[tuple]:
    """Each bit of gc_clock_monitor flips, at a moment drawn by seed: where, and what is seen from then on."""
    rng = np.random.default_rng(seed)
    clocks = Clocks(dut, mhz, seed, CLOCK_LIMIT)
    await clocks.settle()
    clocks.equals_twin = False
    other = "core" if stands == "bus" else "bus"
    for register, bit in [(r, bit) for r in registers(dut) for bit in range(r.bits)]:
        for name in ("bus", "core"):
            clocks.reset(name, True)
            await clocks.run(name, 10)
            clocks.reset(name, False)
        await clocks.run("bus", CLOCK_LIMIT)
        await clocks.run("core", CLOCK_LIMIT)
        assert (dut.core_alive.value, dut.bus_lost.value) == (1, 0)
        if stands:
            clocks.stand(stands)
            await clocks.run(other, 2 * CLOCK_LIMIT)
        await clocks.run(other, int(rng.integers(1, 20)))
        first = len(clocks.seen)
        register.flip(bit)
        await clocks.run(other, 2 * CLOCK_LIMIT)
        yield f"{register} {bit}", np.array(clocks.seen[first:])
        if stands:
            clocks.start(stands)


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def wrong_bit_in_the_clock_monitor_does_nothing_or_the_core_is_told(dut, mhz):
    """core_alive falls for no clock without bus_lost at an edge of the core's clock."""
    n_told, n_flips = 0, 0
    for seed in range(4):
        async for name, seen in seen_after_flips(dut, mhz, "", seed):
            alive, lost, _, core = seen.T
            is_told = (lost[:-1] * np.diff(core)).any()
            assert alive.all() or is_told, name
            n_told, n_flips = n_told + is_told, n_flips + 1
    assert 0 < n_told < n_flips


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def no_wrong_bit_says_that_a_clock_runs_which_stands(dut, mhz):
    """The core's, for no clock; the bus's, until the limit is over once more: the fault was latched long before."""
    async for name, seen in seen_after_flips(dut, mhz, "core", 78):
        assert not seen[:, 0].any(), name
    async for name, seen in seen_after_flips(dut, mhz, "bus", 79):
        assert seen[CLOCK_LIMIT + STAGES + 3 :, 1].all(), name


def test_wrong_bit_in_the_test_and_the_read_back_of_brakes_is_told():
    for entity, test in (("gc_brake_test", "in_the_test"), ("gc_brake_feedback", "in_the_read_back")):
        simulate_flips(entity, "test_rtl_wrong_bits", {"guard_g": "true"}, test)


def test_no_wrong_bit_loads_anything():
    simulate_flips("gc_bus_side", "test_rtl_wrong_bits", {"guard_g": "true"}, "loads_anything")


def test_wrong_bit_in_the_clock_monitor_hides_no_clock_that_stands():
    generics = {"bus_limit_g": CLOCK_LIMIT, "core_limit_g": CLOCK_LIMIT, "stages_g": STAGES}
    tests = "in_the_clock_monitor|which_stands"
    simulate_flips("gc_clock_monitor", "test_rtl_wrong_bits", generics, tests, TIME_UNIT="ps")
