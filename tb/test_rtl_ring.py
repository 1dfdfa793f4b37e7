"""gc_ring: one place per in_valid, round and round; place 0 after reset."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge, Timer

from gravcomp_lab.benches.stream import start
from runner import simulate


@cocotb.test()
async def places_in_turn(dut):
    length, rng = int(os.environ["LENGTH_G"]), np.random.default_rng(14)
    await Timer(1, "ns")
    assert str(dut.out_turn.value) == "1".rjust(length, "0"), "wrong at power-up"
    await start(dut)
    place = 0
    for _ in range(300):
        assert str(dut.out_turn.value) == "1".ljust(place + 1, "0").rjust(length, "0")
        reset, valid = rng.random() < 0.03, rng.random() < 0.6
        dut.rst.value, dut.in_valid.value = int(reset), int(valid)
        place = 0 if reset else (place + valid) % length
        await FallingEdge(dut.clk)


@pytest.mark.parametrize("length", [1, 2, 3, 20])
def test_ring_turns_one_place_per_valid(length):
    simulate("gc_ring", "test_rtl_ring", generics={"length_g": length})
