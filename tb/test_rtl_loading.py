"""gc_system loaded at run time: key, order and arrival of what is loaded, refusal and swap, as the host sees them."""

import itertools
import os
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.task import bridge
from cocotb.triggers import FallingEdge, ReadOnly
from cocotb.utils import get_sim_time

from gravcomp.driver.host import Brakes, Host, Result
from gravcomp_lab.benches.axi import BusError, SimulatedBus
from gravcomp_lab.benches.system import ALL_FAULTS, KICK, System
from loading import image_of, other_weights
from runner import BENCHES, BUILD, simulate
from support.bit_true import assert_bit_true

KEY = 0x4B455953
BEGIN, COMMIT, ROM = 1, 2, 4  # bits of load_command
CRC_FAULT, ROM_FAULT = 1 << 2, 1 << 3
POLLS = 300
LOCKED = [("load_word", 0x12345678), ("load_crc", 0), *(("load_command", bit) for bit in (BEGIN, COMMIT, ROM))]


async def record_loads(dut, loads: list) -> None:
    """Append what reaches the core: kind, and word or CRC."""
    kinds = ("word", "begin", "commit", "rom")
    while True:
        await FallingEdge(dut.clk)
        if dut.i_system.settings_valid.value == 1:
            dut.settings_bits.value = dut.i_system.core_settings_word.value
            await ReadOnly()
            word, found = int(dut.load_word.value), int(dut.load_kinds.value)
            loads += [(kind, word) for bit, kind in enumerate(kinds) if found >> bit & 1]


async def start(dut, axi_mhz: float, core_mhz: float = 40) -> tuple[System, list]:
    """The system after reset, and a list of what will reach its core."""
    system, loads = System(dut), []
    await system.start(axi_mhz, core_mhz)
    cocotb.start_soon(record_loads(dut, loads))
    return system, loads


async def is_refused(registers, name: str, word: int) -> bool:
    try:
        await registers.write(name, word)
    except BusError as error:
        return "SLVERR" in str(error)
    return False


@cocotb.test()
async def locked_without_the_key(dut):
    """After reset, with a wrong key, after the right one was followed by another, and after a commit."""
    system, loads = await start(dut, axi_mhz=40)
    registers = system.registers
    for keys in ([], [0], [KEY ^ 1], [KEY ^ 1 << 31], [KEY, 0], [KEY, KEY + 1]):
        for key in keys:
            await registers.write("load_unlock", key)
        assert await registers.field("load_status", "unlocked") == 0
        assert all([await is_refused(registers, *write) for write in LOCKED]), keys
    await system.clocks(40)
    assert loads == []
    await registers.write("load_unlock", KEY)
    assert await registers.field("load_status", "unlocked") == 1
    for write in LOCKED:
        assert await registers.field("load_status", "unlocked") == 1
        assert not await is_refused(registers, *write)
        if write == ("load_command", COMMIT):
            assert await registers.field("load_status", "unlocked") == 0
            assert all([await is_refused(registers, *again) for again in LOCKED])
            await registers.write("load_unlock", KEY)
    await system.clocks(40)
    assert loads == [("word", 0x12345678), ("begin", 0), ("commit", 0), ("rom", 0)]


@cocotb.test()
async def the_lock_is_that_of_the_write_before(dut):
    """Writes that do not wait for each other's response find the lock as if they did."""
    system, loads = await start(dut, axi_mhz=40)
    registers, writes = system.registers, []
    for name, word in [
        ("load_word", 1), ("load_unlock", KEY), ("load_word", 2), ("load_unlock", 0), ("load_word", 3),
        ("load_unlock", KEY), ("load_word", 4), ("load_command", COMMIT), ("load_word", 5), ("load_command", BEGIN),
    ]:  # fmt: skip
        writes.append(cocotb.start_soon(is_refused(registers, name, word)))
    refused = [await write for write in writes]
    await system.clocks(40)
    assert loads == [("word", 2), ("word", 4), ("commit", 0)]
    assert refused == [True, False, False, False, True, False, False, False, True, True]


@cocotb.test()
@cocotb.parametrize(mhz=[(10, 40), (100, 7.3), (40.01, 40)])
async def every_word_arrives_once_in_order(dut, mhz):
    """Whatever the clocks, with pauses on every channel and other writes between the words."""
    system, loads = await start(dut, *mhz)
    registers, rng = system.registers, np.random.default_rng(41)
    cocotb.log.info("seed 41")
    registers.pause(lambda: (bool(rng.random() < 0.3) for _ in itertools.count()))
    words = [int(word) for word in rng.integers(0, 2**32, 100)]
    await registers.write("load_unlock", KEY)
    await registers.write("load_command", BEGIN)
    for word in words:
        if rng.random() < 0.2:
            await registers.write("command", KICK)
        await registers.write("load_word", word)
    await registers.write("load_crc", 0xDEADBEEF)
    await registers.write("load_command", COMMIT)
    await system.clocks(40)
    assert loads == [("begin", 0), *(("word", word) for word in words), ("commit", 0xDEADBEEF)]


@cocotb.test()
@cocotb.parametrize(mhz=[(100, 40), (100, 20), (100, 7.3), (10, 40)])
async def settings_and_loads_keep_their_order(dut, mhz):
    """A load finds the setting written before it, and not the one written behind it."""
    system = System(dut)
    await system.start(*mhz)
    registers, found, n_writes = system.registers, [], 12

    async def watch() -> None:
        while True:
            await FallingEdge(dut.clk)
            if dut.i_system.settings_valid.value == 1:
                dut.settings_bits.value = dut.i_system.core_settings_word.value
                await ReadOnly()
                if dut.load_kinds.value != 0:
                    found.append((int(dut.load_word.value), int(dut.settings_weights.value)))

    watcher = cocotb.start_soon(watch())
    await registers.write("load_unlock", KEY)
    for n in range(1, n_writes + 1):
        await registers.write("expected_weights", n)
        await registers.write("load_word", n)
    await system.clocks(60)
    watcher.cancel()
    assert found == [(n, n) for n in range(1, n_writes + 1)]


@cocotb.test()
@cocotb.parametrize(mhz=[(10, 40), (100, 40)])
async def time_per_word(dut, mhz):
    system, n_words = System(dut), 40
    await system.start(*mhz)
    await system.registers.write("load_unlock", KEY)
    began = get_sim_time("ns")
    for n in range(n_words):
        await system.registers.write("load_word", n)
    print(f"MEASURED {mhz} MHz: {(get_sim_time('ns') - began) / n_words:.0f} ns per word")


@cocotb.test()
async def refused_image_in_mid_run(dut):
    """Brakes on, crc latched until a new image begins and the fault is cleared; the forces stay those of the ROM."""
    system = System(dut)
    await system.start(axi_mhz=40)
    registers = system.registers
    await system.configure()
    await system.run()
    await registers.write("load_unlock", KEY)
    await registers.write("load_command", BEGIN)
    for word in range(5):
        await registers.write("load_word", word)
    assert dut.brake_release.value == 7
    await registers.write("load_command", COMMIT)
    await system.wait_for_state("fault")
    assert (dut.brake_release.value, dut.drive_enable.value, dut.drive_current.value) == (0, 0, 0)
    assert await registers.read("fault") == await registers.read("first_cause") == CRC_FAULT
    assert await registers.field("load_status", "bad") == 1
    await registers.write("fault", ALL_FAULTS)
    await system.wait_for_state("fault")
    result = await system.result()
    assert_bit_true(result)
    assert (await registers.read("bank_crc"), await registers.field("load_status", "bank")) == (0, 0)
    await registers.write("load_unlock", KEY)
    await registers.write("load_command", BEGIN)
    await registers.write("fault", CRC_FAULT)
    await system.wait_for_state("braked")
    assert await registers.field("load_status", "bad") == 0
    await registers.write("control", system.homing | 2)
    await registers.write("control", system.homing | 3)
    await system.wait_for_state("run")


@cocotb.test()
async def whole_images_in_mid_run(dut):
    """The robot keeps running on an image that is whole, and stops, its forces still of that, on a damaged one."""
    system = System(dut)
    await system.start(axi_mhz=100)
    registers, image = system.registers, image_of(Path(os.environ["OTHER"]))
    host = Host(SimulatedBus(registers))
    load, read = bridge(host.load), bridge(host.read)
    await system.configure(watchdog_clocks=4000, tick_clocks=1000)  # loading takes longer
    await system.run()
    assert_bit_true(await system.result())

    assert await load(image.data, image.crc32, POLLS) == Result.OK
    await registers.write("expected_weights", 0)  # of the ROM: no fault now
    await system.clocks(1100)
    state = await read()
    assert (state.brakes, state.fault, state.cause) == (Brakes.RUN, 0, 0)
    assert (await registers.field("load_status", "bank"), await registers.read("bank_crc")) == (1, image.crc32)
    assert_bit_true(await system.result(), image)

    assert await load(image.data, image.crc32 ^ 1 << 31, POLLS) == Result.REFUSED
    await system.clocks(1100)
    state = await read()
    assert (state.brakes, state.released, state.first_cause) == (Brakes.FAULTED, 0, CRC_FAULT)
    assert (await registers.field("load_status", "bank"), await registers.read("bank_crc")) == (1, image.crc32)
    assert_bit_true(await system.result(), image)

    assert await bridge(host.use_rom)(POLLS) == Result.OK
    await system.clocks(1100)
    state = await read()
    assert state.cause & (ROM_FAULT | CRC_FAULT) == ROM_FAULT
    assert await registers.read("bank_crc") == 0
    assert_bit_true(await system.result())


@cocotb.test()
async def core_without_banks(dut):
    """It says so, and refuses every image."""
    system = System(dut)
    await system.start(axi_mhz=40)
    assert await system.registers.read("load_status") == 0
    assert await system.registers.read("bank_crc") == 0
    await system.registers.write("load_unlock", KEY)
    await system.registers.write("load_command", BEGIN)
    await system.registers.write("load_command", COMMIT)
    await system.clocks(60)
    await system.registers.read("result_number")
    assert await system.registers.read("fault") & CRC_FAULT
    assert await system.registers.field("load_status", "bad") == 1


def simulate_loading(*tests: str, loadable: bool = True, environment: dict[str, str] | None = None) -> None:
    simulate(
        "gc_system_bench",
        "test_rtl_loading",
        tests=rf"\.({'|'.join(tests)})(/|$)",
        label=tests[0],
        generics={"lanes_g": 1, "loadable_g": str(loadable).lower()},
        environment=environment,
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_system_bench")),
    )


def test_loading_needs_the_key():
    simulate_loading("locked_without_the_key", "the_lock_is_that_of_the_write_before")


def test_loading_is_in_order_with_the_settings():
    simulate_loading("settings_and_loads_keep_their_order", "time_per_word")


@pytest.mark.slow
def test_loading_loses_no_word():
    simulate_loading("every_word_arrives_once_in_order")


def test_loading_of_a_damaged_image_engages_the_brakes():
    simulate_loading("refused_image_in_mid_run")


@pytest.mark.slow
def test_loading_of_a_whole_image_changes_the_forces():
    other = other_weights(BUILD / "loading" / "host")
    simulate_loading("whole_images_in_mid_run", environment={"OTHER": str(other)})


def test_loading_needs_banks():
    simulate_loading("core_without_banks", loadable=False)
