"""gc_fixed_pkg: truncation, saturation and its flag, for every value of eight bits."""

import cocotb
from cocotb.triggers import Timer

from gravcomp.twin.network import saturate
from runner import BENCHES, simulate


@cocotb.test()
async def every_value(dut):
    for value in range(-128, 128):
        dut.value.value = value
        await Timer(1, "ns")
        limited, is_limited = saturate(value, 5)
        assert dut.out_truncated.value.to_signed() == value >> 2
        assert dut.out_saturated.value.to_signed() == limited
        assert bool(dut.out_overflows.value) == is_limited


def test_fixed_pkg_equals_model_for_every_value():
    simulate("gc_fixed_bench", "test_rtl_fixed_pkg", extra_sources=(BENCHES / "gc_fixed_bench.vhd",))
