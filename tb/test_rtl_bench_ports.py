"""Ports as integers (gravcomp_lab.benches.ports) are what cocotb makes of them."""

import cocotb
import numpy as np
import pytest
from cocotb.triggers import Timer

from codes import corners_and_random
from gravcomp_lab.benches.ports import driver, is_high, signed, unsigned
from gravcomp_lab.benches.stream import start
from runner import simulate

BITS = 7


@cocotb.test()
async def codes(dut):
    bit, bits, code = is_high(dut.in_valid), unsigned(dut.in_a), signed(dut.in_a)
    await Timer(1, "ns")
    assert not bit(), "U is not high"
    for ask in (bits, code, unsigned(dut.in_valid), signed(dut.in_valid)):
        with pytest.raises(ValueError, match="U"):
            ask()
    await start(dut)
    for value in corners_and_random(BITS, (40,), np.random.default_rng(3)).tolist():
        dut.in_a.value, dut.in_valid.value = value, value & 1
        await Timer(1, "ns")
        assert (code(), bits()) == (value, value % 2**BITS)
        assert (dut.in_a.value.to_signed(), int(dut.in_a.value)) == (code(), bits())
        assert bit() == bool(value & 1)
        assert signed(dut.in_valid)() == unsigned(dut.in_valid)() == value & 1, "one bit has no sign"


@cocotb.test()
async def each_value_once(dut):
    await start(dut)
    drive = driver(dut.in_a)
    for values in ((5, 5, 6), (5, 5)):
        for value in values:
            drive(value)
            await Timer(1, "ns")
            assert int(dut.in_a.value) == value
    dut.in_a.value = 9
    await Timer(1, "ns")
    drive(5)
    await Timer(1, "ns")
    assert int(dut.in_a.value) == 9, "it was given 5 last"


def test_ports_are_the_integers_that_cocotb_has():
    simulate("gc_multiply", "test_rtl_bench_ports", generics={"a_bits_g": BITS, "b_bits_g": 3})
