"""gc_clock_monitor equals its twin at every edge of both clocks: a clock that stops is found, one that runs is not."""

import os

import cocotb
import numpy as np
from cocotb.triggers import Timer

from gravcomp.twin.guards import ClockMonitor
from runner import simulate

MHZ = [(10, 40), (40, 10), (40, 40), (40, 40.01), (100, 7.3), (7.3, 100), (33.333, 40)]
STAGES, LIMIT = 2, 64
# Of all times; a simulator of Verilog knows none so short, and does as well with longer ones.
UNIT = os.environ.get("TIME_UNIT", "fs")
FOREVER = 2**62


class Clocks:
    """Both clocks, each with a phase of its own and times at which it stands, and the twin beside the entity."""

    # Not from when on a bit is wrong.
    equals_twin = True

    def __init__(self, dut, mhz: tuple[float, float], seed: int, limit: int = LIMIT) -> None:
        rng = np.random.default_rng(seed)
        cocotb.log.info("seed %d", seed)
        self.dut, self.now = dut, 0
        self.twin = ClockMonitor(limit, limit, int(os.environ["STAGES_G"]))
        self.period = {name: 2 * round(5e8 / f) for name, f in zip(("bus", "core"), mhz, strict=True)}
        self.next = {name: 2 * int(rng.integers(1, period // 2)) for name, period in self.period.items()}
        self.next["bus"] += 1  # no two edges together: what a synchroniser then takes is left to the simulator
        self.rst = {"bus": False, "core": False}
        self.edges = {"bus": 0, "core": 0}
        self.seen = []  # core_alive and bus_lost, and the edges of both clocks so far
        for name in ("bus_clk", "core_clk", "bus_rst", "core_rst"):
            getattr(dut, name).value = 0

    async def settle(self) -> None:
        """The state of power-up, or all of its levels inverted, which is the same to the outputs."""
        for name in ("bus", "core"):
            self.reset(name, True)
        await self.bare_edges("bus", 3)
        await self.bare_edges("core", 4 * STAGES)
        for _ in range(4 * STAGES):
            if self.dut.trip.value == 1:
                break
            await self.bare_edges("bus", 1)
        else:
            raise AssertionError("no trip ends")
        for name in ("bus", "core"):
            self.reset(name, False)

    async def bare_edges(self, name: str, n_edges: int) -> None:
        """Edges that the twin does not see."""
        for level in (1, 0) * n_edges:
            getattr(self.dut, f"{name}_clk").value = level
            await Timer(2, UNIT)

    def stand(self, name: str, fs: int = FOREVER) -> None:
        """The clock makes no edge for that long, or until it starts."""
        self.next[name] += fs

    def start(self, name: str) -> None:
        self.next[name] = self.now + self.period[name] + (self.now + (name == "bus")) % 2

    def trip(self, name: str) -> float:
        """Longest round trip, in clocks of that side."""
        time = (STAGES + 2) * self.period["bus"] + (STAGES + 1) * self.period["core"]
        return time / self.period[name]

    def reset(self, name: str, level: bool) -> None:
        self.rst[name] = level
        getattr(self.dut, f"{name}_rst").value = int(level)

    async def run(self, name: str, n_edges: int) -> None:
        """Until the clock has made so many rising edges more; outputs equal the twin's before each edge of either."""
        last = self.edges[name] + n_edges
        while self.edges[name] < last:
            await self.edge(min(self.next, key=self.next.get))

    async def edge(self, name: str) -> None:
        """The next edge, which is one of that clock."""
        await self.wait_until(self.next[name])
        alive, lost = bool(self.dut.core_alive.value), bool(self.dut.bus_lost.value)
        assert not self.equals_twin or (alive, lost) == (self.twin.core_alive, self.twin.bus_lost), self.edges
        self.seen.append((alive, lost, self.edges["bus"], self.edges["core"]))
        getattr(self.dut, f"{name}_clk").value = 1
        getattr(self.twin, f"{name}_clock")(self.rst[name])
        self.edges[name] += 1
        self.next[name] += self.period[name]
        await self.wait_until(self.now + min(self.period.values()) // 8)
        getattr(self.dut, f"{name}_clk").value = 0

    async def wait_until(self, fs: int) -> None:
        if fs > self.now:
            await Timer(fs - self.now, UNIT)
            self.now = fs

    async def up(self) -> None:
        """Until both sides know that the other one runs."""
        while not self.twin.core_alive or self.twin.bus_lost:
            await self.run("bus", 1)
            assert self.edges["bus"] < 40 * LIMIT


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def clocks_that_run_are_no_fault(dut, mhz):
    clocks = Clocks(dut, mhz, seed=71)
    await clocks.settle()
    await clocks.up()
    first = len(clocks.seen)
    await clocks.run("bus" if mhz[0] < mhz[1] else "core", 30 * LIMIT)
    alive, lost = np.array(clocks.seen[first:])[:, :2].T
    assert alive.all()
    assert not lost.any()


@cocotb.test()
@cocotb.parametrize(mhz=MHZ, late=["bus", "core"])
async def a_clock_that_starts_late_is_none_that_stopped(dut, mhz, late):
    """Not alive, and nothing lost, but for a core that waits longer than the limit; afterwards both run."""
    other = {"bus": "core", "core": "bus"}[late]
    clocks = Clocks(dut, mhz, seed=72)
    await clocks.settle()
    clocks.stand(late)
    clocks.reset("bus", True)
    clocks.reset("core", True)
    await clocks.run(other, 10)
    clocks.reset(other, False)
    await clocks.run(other, 5 * LIMIT)
    assert not any(alive for alive, *_ in clocks.seen)
    assert any(lost for _, lost, *_ in clocks.seen) == (late == "bus")
    clocks.start(late)
    await clocks.run(late, 10)
    clocks.reset(late, False)
    await clocks.up()


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def a_core_whose_clock_stops_is_found_and_told(dut, mhz):
    """core_alive falls within the limit and a trip; when the clock is back, the core hears of it before it rises."""
    clocks = Clocks(dut, mhz, seed=73)
    await clocks.settle()
    await clocks.up()
    await clocks.run("core", 100)
    clocks.stand("core")
    first = clocks.edges["bus"]
    await clocks.run("bus", 3 * LIMIT)
    falls = next(bus for alive, _, bus, _ in clocks.seen if bus >= first and not alive)
    print(f"MEASURED {mhz} MHz: core_alive falls after {falls - first} clocks of bus_clk")
    assert LIMIT - clocks.trip("bus") <= falls - first <= LIMIT + STAGES + 3
    clocks.start("core")
    stopped = len(clocks.seen)
    await clocks.up()
    told = [core for alive, lost, _, core in clocks.seen[stopped:] if lost and not alive]
    assert len(set(told)) >= 2 * STAGES + 2, "clocks of the core with bus_lost, before core_alive rises"


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def a_bus_whose_clock_stops_is_found(dut, mhz):
    clocks = Clocks(dut, mhz, seed=74)
    await clocks.settle()
    await clocks.up()
    await clocks.run("bus", 100)
    clocks.stand("bus")
    first = clocks.edges["core"]
    await clocks.run("core", 3 * LIMIT)
    rises = next(core for _, lost, _, core in clocks.seen if core >= first and lost)
    print(f"MEASURED {mhz} MHz: bus_lost rises after {rises - first} clocks of core_clk")
    assert LIMIT - clocks.trip("core") <= rises - first <= LIMIT + STAGES + 3
    clocks.start("bus")
    await clocks.up()


@cocotb.test()
async def random_stops_and_resets(dut):
    """Either clock stands for a while, again and again, either side is reset: equal to the twin at every edge."""
    clocks, rng = Clocks(dut, (33.333, 40), seed=75), np.random.default_rng(76)
    await clocks.settle()
    for _ in range(60):
        name = rng.choice(["bus", "core"])
        if rng.random() < 0.3:
            clocks.reset(name, True)
            await clocks.run(name, int(rng.integers(1, 5)))
            clocks.reset(name, False)
        clocks.stand(name, 2 * int(rng.integers(1, 2 * LIMIT * clocks.period[name] // 2)))
        await clocks.run(name, int(rng.integers(1, 3 * LIMIT)))
    outputs = {seen[:2] for seen in clocks.seen}
    assert outputs == {(False, True), (True, False), (True, True), (False, False)}


def test_clock_monitor_finds_a_clock_that_stands_and_no_other():
    limits = {"bus_limit_g": LIMIT, "core_limit_g": LIMIT}
    simulate("gc_clock_monitor", "test_rtl_clock_monitor", generics={**limits, "stages_g": STAGES})
