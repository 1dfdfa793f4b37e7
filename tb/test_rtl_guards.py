"""gc_system with its guards: a clock that stops engages the brakes, and so do brakes, paths and settings gone wrong."""

import cocotb
import pytest
from cocotb.triggers import FallingEdge, Timer
from cocotb.utils import get_sim_time

from codes import fixed_network
from gravcomp_lab.benches.changes import value_change
from gravcomp_lab.benches.system import ALL_FAULTS, KICK, System
from runner import BENCHES, simulate

ALL = (1 << fixed_network().n_axes) - 1
BRAKE, CLOCK, UPSET = 1 << 12, 1 << 13, 1 << 15
WATCH = 256  # clock_watch_g
MHZ = [(10, 40), (40, 40.01), (100, 7.3), (40, 10)]


class Guarded(System):
    """The system with clocks that can be stopped, and a record of the pins of its brakes."""

    async def start(self, axi_mhz: float, core_mhz: float = 40) -> None:
        self.core_period = 2 * round(5e8 / core_mhz)
        self.axi_period = 2 * round(5e8 / axi_mhz)
        self.dut.brake_fails.value = 0
        await super().start(axi_mhz, core_mhz)
        self.opened = []
        cocotb.start_soon(self.record())

    async def record(self) -> None:
        """Times at which the brakes are opened or shut, fs, and which are open then."""
        while True:
            await value_change(self.dut.brakes_open)
            self.opened.append((round(get_sim_time("fs")), int(self.dut.brakes_open.value)))

    def is_braked(self) -> bool:
        """No brake is open, and the drives are off."""
        return (int(self.dut.brakes_open.value), int(self.dut.drive_enable.value)) == (0, 0)

    async def again(self) -> None:
        """Clear all faults and release the brakes, of axes that are referenced."""
        await self.registers.write("control", self.homing | 2)
        await self.registers.write("command", KICK)
        await self.clocks(250)
        await self.registers.write("fault", ALL_FAULTS)
        await self.wait_for_state("braked")
        await self.registers.write("control", self.homing | 3)
        await self.wait_for_state("run")

    async def causes(self) -> int:
        """Faults latched."""
        await self.registers.read("result_number")
        return await self.registers.read("fault")


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def core_clock_that_stops_engages_the_brakes(dut, mhz):
    """Within the limit and a round trip; they stay so when it is back, and the fault is latched."""
    system = Guarded(dut)
    await system.start(*mhz)
    await system.configure()
    await system.run()
    await system.registers.write("interrupt_status", 15)
    await system.registers.write("interrupt_enable", 8)
    await system.clocks(100)
    assert int(dut.brakes_open.value) == ALL
    system.core_clock.stop()
    stopped = round(get_sim_time("fs"))
    await Timer(3 * WATCH * system.axi_period, "fs")
    assert system.is_braked()
    reaction = (system.opened[-1][0] - stopped) / system.axi_period
    print(f"MEASURED {mhz} MHz: brakes engaged {reaction:.1f} clocks of the host after the core's clock stopped")
    assert reaction <= WATCH + 6
    assert dut.irq.value == 1
    assert await system.registers.read("interrupt_status") & 8
    assert await system.registers.field("guards", "core_clock") == 0
    n_changes = len(system.opened)
    system.core_clock.start()
    await system.clocks(400)
    assert len(system.opened) == n_changes, "opened again by itself"
    assert await system.registers.field("guards", "core_clock") == 1
    assert await system.causes() & CLOCK
    await system.again()
    assert int(dut.brakes_open.value) == ALL


@cocotb.test()
@cocotb.parametrize(mhz=MHZ)
async def host_clock_that_stops_engages_the_brakes(dut, mhz):
    system = Guarded(dut)
    await system.start(*mhz)
    await system.configure()
    await system.run()
    system.axi_clock.stop()
    stopped = round(get_sim_time("fs"))
    await system.clocks(2 * WATCH)
    assert system.is_braked()
    reaction = (system.opened[-1][0] - stopped) / system.core_period
    print(f"MEASURED {mhz} MHz: brakes engaged {reaction:.1f} clocks of the core after the host's clock stopped")
    assert reaction <= WATCH + 8
    system.axi_clock.start()
    await system.clocks(400)
    assert system.is_braked()
    assert await system.causes() == CLOCK
    await system.again()


@cocotb.test()
@cocotb.parametrize(mhz=[(10, 40), (100, 7.3)], late=["core", "axi"])
async def clocks_that_start_late_are_no_fault(dut, mhz, late):
    system = Guarded(dut)
    await system.start(*mhz)
    clock = getattr(system, f"{late}_clock")
    clock.stop()
    dut.s_axi_aresetn.value = 0
    await Timer(4 * WATCH * max(system.core_period, system.axi_period), "fs")
    clock.start()
    await Timer(20 * max(system.core_period, system.axi_period), "fs")
    dut.s_axi_aresetn.value = 1
    await system.clocks(200)
    await system.configure()
    assert not await system.causes() & CLOCK
    await system.run()


@cocotb.test()
async def brakes_that_do_not_obey_engage_all(dut):
    """Each axis: its read-back is wrong in RUN, and for a moment too short to count."""
    system = Guarded(dut)
    await system.start(axi_mhz=40)
    await system.configure(brake_clocks=20, brake_test_clocks=6)
    await system.run()
    for axis in range(system.n_axes):
        dut.brake_fails.value = 1 << axis
        await system.clocks(15)
        dut.brake_fails.value = 0
        await system.clocks(100)
        assert int(dut.brakes_open.value) == ALL
        dut.brake_fails.value = 1 << axis
        await system.clocks(40)
        assert system.is_braked()
        assert await system.causes() & BRAKE
        assert await system.registers.field("guards", "feedback") == 1 << axis
        dut.brake_fails.value = 0
        await system.again()


@cocotb.test()
async def brakes_are_tested_before_they_open(dut):
    """Each alone, with the load carried, then all; one that fails keeps all of them engaged."""
    system = Guarded(dut)
    await system.start(axi_mhz=40)
    await system.configure(brake_clocks=20, brake_test_clocks=6, hold_clocks=10_000)
    await system.run()
    assert [which for _, which in system.opened] == [1, 0, 2, 0, 4, 0, ALL]
    await system.registers.write("control", system.homing | 2)
    await system.clocks(100)
    system.opened.clear()
    # the read-back of axis 2 stays where it is while its brake is tested
    cocotb.start_soon(fail_while_open(dut, 0b010))
    with pytest.raises(AssertionError, match="not run"):
        await system.again()
    assert ALL not in [which for _, which in system.opened]
    assert await system.causes() & BRAKE


async def fail_while_open(dut, axes: int) -> None:
    while True:
        await FallingEdge(dut.clk)
        dut.brake_fails.value = int(dut.brakes_open.value) & axes


@cocotb.test()
async def settings_with_a_wrong_bit_engage_the_brakes(dut):
    """In RUN; then each bit of those that the core holds, commands and loads too, is told to be wrong."""
    system = Guarded(dut)
    await system.start(axi_mhz=40)
    await system.configure()
    await system.run()
    core, word = dut.i_system.i_core_side, dut.i_system.core_settings_word
    word.value = int(word.value) ^ 1 << 100
    await system.clocks(60)
    assert system.is_braked()
    assert await system.causes() & UPSET
    word.value = int(word.value) ^ 1 << 100
    await system.clocks(1)
    for bit in range(int(dut.watched_bits.value)):
        right = int(word.value)
        for value, is_bad in ((right ^ 1 << bit, 1), (right, 0)):
            word.value = value
            await system.clocks(1)
            assert core.setting_bad.value == is_bad, bit


def simulate_guards(*tests: str, **generics) -> None:
    simulate(
        "gc_system_bench",
        "test_rtl_guards",
        tests=rf"\.({'|'.join(tests)})(/|$)",
        label=tests[0],
        generics={"lanes_g": 4, "loadable_g": "false", **generics},
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_system_bench")),
    )


@pytest.mark.slow
def test_clocks_that_stop_engage_the_brakes():
    simulate_guards(
        "core_clock_that_stops_engages_the_brakes",
        "host_clock_that_stops_engages_the_brakes",
        "clocks_that_start_late_are_no_fault",
    )


@pytest.mark.slow
def test_brakes_are_watched_and_tested():
    simulate_guards("brakes_that_do_not_obey_engage_all", brake_feedback_g="true")
    simulate_guards("brakes_are_tested_before_they_open", brake_feedback_g="true", brake_test_g="true")


@pytest.mark.slow
def test_wrong_settings_engage_the_brakes():
    simulate_guards("settings_with_a_wrong_bit_engage_the_brakes")
