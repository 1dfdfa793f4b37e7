"""gc_weight_rom: the words of a lane in turn, the next ready beside in_valid; word 0 after the last and after reset."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from gravcomp_lab.benches.stream import start
from runner import BENCHES, simulate


@cocotb.test()
async def words_in_turn(dut):
    n_words, lanes, lane = (int(os.environ[name]) for name in ("WORDS_G", "LANES_G", "LANE_G"))
    words = list(range(lane + 1, n_words + 1, lanes))
    words += [0] * (-(-n_words // lanes) - len(words))  # zeros where the lanes do not divide the words
    rng = np.random.default_rng(9)
    await start(dut)
    position = 0
    for _ in range(200):
        assert int(dut.out_word.value) == words[position % len(words)]
        reset, valid = rng.random() < 0.03, rng.random() < 0.6
        dut.rst.value, dut.in_valid.value = int(reset), int(valid)
        position = 0 if reset else position + valid
        await FallingEdge(dut.clk)


@pytest.mark.parametrize(
    ("words", "lanes", "lane"), [(20, 1, 0), (20, 4, 3), (20, 20, 19), (6, 2, 1), (8, 1, 0), (7, 2, 1)]
)
@pytest.mark.parametrize("ring", ["false", "true"])
def test_weight_rom_gives_the_words_of_its_lane(words, lanes, lane, ring):
    generics = {"words_g": words, "lanes_g": lanes, "lane_g": lane, "ring_g": ring}
    bench = (BENCHES / "gc_weight_rom_bench.vhd",)
    simulate("gc_weight_rom_bench", "test_rtl_weight_rom", generics=generics, extra_sources=bench)
