"""Loading at run time: gc_force_path computes with whole sets only, each its model's; what is wrong is refused."""

import os
import zlib
from itertools import groupby
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from codes import fixed_compensation, fixed_network
from compensated import compensated_weights
from loading import FIRST, LOAD_PORTS, ROM, SECOND, SPHEIRO, image_of, moving, other_weights
from runner import BENCHES, BUILD, simulate

WEIGHTS = BUILD / "loading"


def images():
    """The other weights, and those of the Sphe.I.Ro. without a compensator."""
    return image_of(Path(os.environ["OTHER"])), image_of(SPHEIRO)


def sets(first, second) -> dict:
    """Constants of ROM and banks, for LoadBench.banks_of_results."""
    rom = (fixed_network(), fixed_compensation())
    return {ROM: rom, FIRST: (first.network, first.compensation), SECOND: (second.network, second.compensation)}


def in_turn(banks: list[int]) -> list[int]:
    return [bank for bank, _ in groupby(banks)]


@cocotb.test()
async def swaps(dut):
    """Inferences back to back through a commit and the return to the ROM: none is lost, none is a mixture."""
    (other, plain), n_clocks = images(), 120 + 160 // int(os.environ["LANES_G"])
    bench = await moving(dut, other.network)
    bench.load(other)
    await bench.finish_script(but=60)
    bench.commit(other.crc32)
    bench.pace = 1.0
    await bench.clocks(60 + n_clocks)
    assert dut.sts_bank.value == FIRST
    assert int(dut.sts_bank_crc.value) == other.crc32
    bench.rom()
    await bench.clocks(n_clocks)
    assert in_turn(await bench.banks_of_results(sets(other, plain))) == [ROM, FIRST, ROM]
    assert dut.sts_bank.value == ROM
    assert int(dut.sts_bank_crc.value) == 0


@cocotb.test()
async def banks_in_turn(dut):
    """While an image goes into one bank nothing changes in the other; a reset forgets them all."""
    other, plain = images()
    bench = await moving(dut, other.network)
    bench.pace = 0.02
    bench.load(other, n_words=99)
    bench.commit(other.crc32)
    await bench.finish_script()
    assert dut.sts_load_bad.value == 1
    bench.load(other)
    bench.commit(other.crc32)
    await bench.clocks(2)
    assert dut.sts_load_bad.value == 0
    await bench.finish_script()
    await bench.clocks(60)
    bench.load(plain)
    await bench.finish_script()
    assert dut.sts_bank.value == FIRST, "the second image is not yet committed"
    bench.pace = 1.0
    bench.commit(plain.crc32)
    await bench.clocks(100)
    bench.rom()
    await bench.finish_script()
    assert dut.sts_load_waiting.value == 1
    bench.begin()
    await bench.clocks(2)
    assert dut.sts_load_waiting.value == 0
    await bench.clocks(60)
    assert in_turn(await bench.banks_of_results(sets(other, plain))) == [ROM, FIRST, SECOND]
    bench.pace = 1.0
    await bench.clocks(50)
    await bench.reset()
    bench.pace = 0.5
    await bench.clocks(100)
    assert in_turn(await bench.banks_of_results(sets(other, plain))) == [SECOND, ROM]
    assert int(dut.sts_bank_crc.value) == 0


@cocotb.test()
async def refusals(dut):
    """A commit is refused when a word is missing or too many or damaged, the CRC is another one, or nothing began."""
    words = [int(word) for word in image_of(SPHEIRO).words]
    crc32 = image_of(SPHEIRO).crc32
    Clock(dut.clk, 10, "ns").start(start_high=False)
    dut.in_bank.value = 0
    dut.rst.value = 1

    async def clock(**ports) -> None:
        for name in LOAD_PORTS:
            getattr(dut, name).value = ports.get(name, 0)
        await FallingEdge(dut.clk)

    async def is_accepted(sent: list[int], crc: int, begins: bool = True) -> bool:
        if begins:
            await clock(load_begin=1)
            assert dut.sts_bad.value == 0
        for word in sent:
            await clock(load_valid=1, load_word=word)
        await clock(load_commit=1, load_crc=crc)
        accepted, bad = int(dut.out_accept.value), int(dut.sts_bad.value)
        await clock()
        assert accepted != bad
        assert dut.out_accept.value == 0
        assert dut.sts_bad.value == bad
        return bool(accepted)

    def crc_of(sent: list[int]) -> int:
        return zlib.crc32(np.array(sent, "<u4").tobytes())

    await clock()
    dut.rst.value = 0
    assert not await is_accepted(words, crc32, begins=False)
    assert await is_accepted(words, crc32)
    assert int(dut.out_crc.value) == crc32
    assert not await is_accepted([], crc32, begins=False), "a second commit"
    assert not await is_accepted(words[:-1], crc_of(words[:-1]))
    for n_more in (1, 2):
        more = [*words, *words[:n_more]]
        assert not await is_accepted(more, crc_of(more)), f"{n_more} too many"
    damaged = [*words[:200], words[200] ^ 1 << 17, *words[201:]]
    assert not await is_accepted(damaged, crc32)
    await clock(load_begin=1)
    for word in words[:300]:
        await clock(load_valid=1, load_word=word)
    assert await is_accepted(words, crc32), "a new beginning forgets what came before"
    await clock(load_begin=1)
    dut.rst.value = 1
    await clock()
    dut.rst.value = 0
    assert not await is_accepted(words, crc32, begins=False), "a reset ends the loading"
    dut.rst.value = 1
    await clock()
    assert dut.sts_bad.value == 0, "a reset forgets the refusal"


@pytest.mark.parametrize("lanes", [1, 4, pytest.param(20, marks=pytest.mark.slow)])
def test_every_result_is_that_of_one_set_of_constants(lanes):
    simulate_loadable("swaps", lanes)


@pytest.mark.slow
def test_banks_follow_each_other_and_a_reset_returns_to_the_rom():
    simulate_loadable("banks_in_turn", 4)


def test_what_is_not_the_image_is_refused():
    simulate("gc_loader", "test_rtl_loader", tests="refusals$")


def simulate_loadable(test: str, lanes: int) -> None:
    rom, other = compensated_weights(WEIGHTS / "rom"), other_weights(WEIGHTS / "other")
    simulate(
        "gc_force_path_bench",
        "test_rtl_loader",
        generics={"lanes_g": lanes, "loadable_g": "true"},
        environment={"WEIGHTS": str(rom), "OTHER": str(other)},
        generated=rom / "generated",
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_force_path_bench")),
        tests=f"{test}$",
        label=test,
    )
