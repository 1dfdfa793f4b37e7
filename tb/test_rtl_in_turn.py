"""gc_in_turn: values that come at once go out one per clock, the first at once, each with its number."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge, Timer

from gravcomp_lab.benches.stream import start
from runner import simulate

BITS = 18


@cocotb.test()
async def values_go_out_in_order(dut):
    """At any distance of theirs or more, whatever the ports carry meanwhile; after a reset none that waited."""
    n, rng = int(os.environ["VALUES_G"]), np.random.default_rng(4)
    await start(dut)
    waiting, clocks_to_next = [], 0
    for clock in range(600):
        values = [int(value) for value in rng.integers(0, 2**BITS, n)]
        begins = clocks_to_next <= 0 and rng.random() < 0.7
        resets = bool(rng.random() < 0.05)
        dut.in_values.value = sum(value << BITS * k for k, value in enumerate(values))
        dut.in_valid.value = int(begins)
        dut.rst.value = int(resets)
        if begins:
            assert not waiting
            waiting, clocks_to_next = list(enumerate(values)), n
        await Timer(1, "ns")
        assert dut.out_valid.value == bool(waiting), f"clock {clock}"
        if waiting:
            assert (int(dut.out_turn.value), int(dut.out_value.value)) == waiting.pop(0)
        clocks_to_next -= 1
        if resets:
            waiting, clocks_to_next = [], 0
        await FallingEdge(dut.clk)


@pytest.mark.parametrize("values", [1, 2, 3, 4, 5, 8])
def test_values_go_out_in_order(values):
    simulate("gc_in_turn", "test_rtl_in_turn", generics={"values_g": values, "bits_g": BITS})
