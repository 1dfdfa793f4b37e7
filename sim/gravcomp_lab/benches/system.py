"""gc_system with its encoders and its host: a bench, and the path from an encoder's edge to the command."""

from dataclasses import dataclass
from pathlib import Path

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, with_timeout

from gravcomp.core.formats import COUNT_BITS
from gravcomp.facts import Cause, State
from gravcomp.simulation.measured import hand_over
from gravcomp_lab.benches.axi import Registers
from gravcomp_lab.benches.bench import run_bench
from gravcomp_lab.benches.changes import until
from gravcomp_lab.benches.codes import fixed_network, hash_under_test, pack, unpack
from gravcomp_lab.shipped import ROOT

BENCH_SOURCES = tuple(ROOT / "tb" / "hdl" / f"{name}.vhd" for name in ("gc_encoder_model", "gc_system_bench"))
ALL_FAULTS = (1 << len(Cause)) - 1
KICK = 2  # of command
STATES = {state.name.lower(): state for state in State}
HOME_BIT = 4  # of control, of axis 1
# More than any walk of these tests takes, and than a word takes to cross.
WALK_CLOCKS, CROSSING_CLOCKS = 1_000_000, 1000


def near_the_middle() -> np.ndarray:
    """Counts (n,) near the middle of the trained range, where an index can be; of the Sphe.I.Ro. 2002, -3002, 4002."""
    fixed = fixed_network()
    axis = np.arange(fixed.n_axes)
    aside = np.minimum(2002 + 1000 * axis, (fixed.count_high - fixed.count_low) // 8)
    counts = (fixed.count_low + fixed.count_high) // 2 + np.where(axis % 2, -aside, aside)
    return counts - (counts - 2) % 4


class System:
    """gc_system_bench with both clocks running, and its host."""

    def __init__(self, dut):
        self.dut, self.n_axes = dut, fixed_network().n_axes
        self.all_axes = (1 << self.n_axes) - 1
        self.homing = self.all_axes << HOME_BIT  # of control

    @property
    def near(self) -> np.ndarray:
        return near_the_middle()

    async def start(self, axi_mhz: float, core_mhz: float = 40) -> None:
        """Start the clocks and reset; every register then holds its reset value."""
        dut = self.dut
        self.core_clock = Clock(dut.clk, 2 * round(5e8 / core_mhz), "fs")
        self.core_clock.start()
        self.axi_clock = Clock(dut.s_axi_aclk, 2 * round(5e8 / axi_mhz), "fs")
        self.axi_clock.start()
        dut.target.value = dut.index_count.value = 0
        dut.load.value = 1  # near 0, if an earlier test has left the axes elsewhere
        dut.clocks_per_edge.value = 4
        dut.estop_n.value = 1
        for port in ("awvalid", "wvalid", "bready", "arvalid", "rready"):
            getattr(dut, f"s_axi_{port}").value = 0
        dut.s_axi_aresetn.value = 0
        await self.clocks(2)
        dut.load.value = 0
        await self.clocks(40)
        self.registers = Registers(dut)  # only now: it takes no 'U' on the ready pins
        dut.s_axi_aresetn.value = 1
        await self.clocks(60)

    async def clocks(self, n: int) -> None:
        for _ in range(n):
            await FallingEdge(self.dut.clk)

    async def home_near(self, counts: np.ndarray) -> None:
        """Home the axes, by the registers, at indices beside the counts."""
        index = counts - (counts - 2) % 4  # the decoder takes the index in phase 2
        await self.registers.write_axes("index_position", index)
        await self.registers.write("control", 0)
        await self.registers.write("control", self.homing)
        await self.put_before(index)
        await self.walk_to(index)
        assert await self.registers.read("result_number") == 0
        assert await self.registers.field("encoder_flags", "referenced") == self.all_axes

    async def put_before(self, index: np.ndarray) -> None:
        """A jump of whole encoder cycles to two of them before the index: the last one is on the pins, without z."""
        await self.clocks(1)
        self.dut.index_count.value = self.dut.target.value = pack(index - 8, COUNT_BITS)
        self.dut.load.value = 1
        await self.clocks(1)
        self.dut.load.value = 0
        self.dut.index_count.value = pack(index, COUNT_BITS)

    async def walk_to(self, counts: np.ndarray) -> None:
        self.dut.target.value = pack(counts, COUNT_BITS)
        await self.clocks(2)
        await until(self.dut.clk, "the end of the walk", lambda: self.dut.busy.value == 0, WALK_CLOCKS)
        await self.clocks(60)  # decoder and crossing

    async def configure(self, **changes: int) -> None:
        """Limits that nothing here exceeds, and the hash that the core has."""
        values = {
            "expected_weights": int(hash_under_test()[:8], 16),
            "current_limit_ua": 2**31 - 1,
            "current_slew_ua": 2**31 - 1,
            "period_min_clocks": 8,
            "saturation_clocks": 10_000,
            "watchdog_clocks": 100_000,
            "result_clocks": 10_000,
            "brake_clocks": 20,
            "command_bound_ua": 1000,
            "command_clocks": 500,
            "hold_clocks": 100_000,
            "brake_test_clocks": 6,
            "tick_clocks": 150,
            **changes,
        }
        for name, value in values.items():
            await self.registers.write_all(name, value)
        fixed = fixed_network()
        await self.registers.write_axes("window_low", fixed.count_low - 100)
        await self.registers.write_axes("window_high", fixed.count_high + 100)

    async def run(self) -> None:
        """Home, tick and release the brakes."""
        await self.enable(self.near)
        await self.wait_for_state("run")

    async def enable(self, counts: np.ndarray) -> None:
        """Home near the counts, tick, and enable while no cause is present."""
        await self.home_near(counts)
        await self.registers.write("control", self.homing | 2)
        await self.registers.write("command", KICK)
        await self.clocks(250)
        await self.registers.write("fault", ALL_FAULTS)
        await self.wait_for_state("braked")
        await self.registers.write("control", self.homing | 3)

    async def wait_for_state(self, name: str, most_reads: int = 500) -> None:
        for _ in range(most_reads):
            await self.registers.read("result_number")
            if await self.registers.field("status", "state") == STATES[name]:
                return
        raise AssertionError(f"not {name}: {await self.registers.read('status'):#x}")

    async def interrupt(self) -> None:
        """Wait for irq."""
        if self.dut.irq.value != 1:
            await with_timeout(RisingEdge(self.dut.irq), 1, "ms")

    async def result(self) -> dict[str, np.ndarray]:
        """One whole result, position to current, and its number."""
        number = await self.registers.read("result_number")
        names = ("position", "speed_period", "force_mn", "current_ua")
        return {"number": number, **{name: np.array(await self.registers.read_axes(name)) for name in names}}


@cocotb.test()
async def path_latency(dut):
    """Clocks from an edge on an encoder pin to the command that knows it, at every phase of the tick."""
    system, tick_clocks = System(dut), 60
    await system.start(axi_mhz=10)
    await system.configure(tick_clocks=tick_clocks)
    await system.run()
    controller = dut.i_system.i_core_side
    dut.clocks_per_edge.value = tick_clocks + 1  # every phase of the tick
    dut.target.value = pack(system.near + 3000 * (np.arange(system.n_axes) == 0), COUNT_BITS)
    count, starts, latencies, steps = 2002, [], [], set()
    edges, pins, counted = [], None, None
    for clock in range(70 * 61):
        await FallingEdge(dut.clk)
        now = (int(dut.pin_a.value) & 1, int(dut.pin_b.value) & 1)
        if pins not in (None, now):
            count += 1
            edges.append((count, clock))
        pins = now
        known = unpack([int(controller.count.value)], COUNT_BITS, system.n_axes)[0][0]
        if counted not in (None, known):
            to_count = clock - edges[-1][1]
        counted = known
        if controller.begins.value == 1:
            starts.append((known, clock))
        if controller.path_valid.value == 1 and starts:
            to_current = clock - starts[-1][1]
        if dut.drive_valid.value == 1 and starts:
            known, began = starts.pop()
            if latencies:
                steps.add((to_count, to_current, clock - began - to_current))
            while edges and edges[0][0] <= known:
                latencies.append(clock - edges.pop(0)[1])
    assert len(steps) == 1
    hand_over(steps=list(*steps), clocks=latencies, tick_clocks=tick_clocks)


@dataclass(frozen=True)
class EdgePath:
    """From an edge on an encoder pin to the command that knows it.

    to_count, to_current, to_command: clocks from edge to count, from a tick to the current asked for, and through the
    limits; clocks (k,): of k edges, at every phase of a tick of tick_clocks.
    """

    to_count: int
    to_current: int
    to_command: int
    clocks: np.ndarray
    tick_clocks: int

    @property
    def shortest(self) -> int:
        """Clocks of an edge that comes just before its tick."""
        return int(self.clocks.min())


def path_of(measured: dict) -> EdgePath:
    """What a simulation of path_latency handed over."""
    return EdgePath(*measured["steps"], np.array(measured["clocks"]), measured["tick_clocks"])


def path_run(lanes: int, rtl: Path, build: Path, weights: Path) -> EdgePath:
    """The path through gc_system with so many lanes, simulated under GHDL with the ROM in rtl, made from weights."""
    measured = run_bench(
        "gc_system_bench",
        __name__,
        lanes,
        rtl,
        build / f"path-{lanes}",
        {"WEIGHTS": str(weights.absolute())},
        BENCH_SOURCES,
        tests="path_latency$",
    )
    return path_of(measured)
