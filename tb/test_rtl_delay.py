"""gc_delay: its input, clocks_g clocks later."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from runner import simulate


@cocotb.test()
async def input_comes_out_later(dut):
    clocks = int(os.environ["CLOCKS_G"])
    words = np.random.default_rng(10).integers(0, 32, 100).tolist()
    Clock(dut.clk, 10, "ns").start(start_high=False)
    for k, word in enumerate(words):
        dut.in_data.value = word
        await FallingEdge(dut.clk)
        if k >= clocks:
            assert int(dut.out_data.value) == words[k + 1 - clocks]


@pytest.mark.parametrize("clocks", [1, 2, 9])
def test_delay_is_its_number_of_clocks(clocks):
    simulate("gc_delay", "test_rtl_delay", generics={"bits_g": 5, "clocks_g": clocks})
