"""gc_encoder_pkg: the limit speed that the VHDL states is that of the twin, for every filter of 0 to 15 samples."""

import cocotb
from cocotb.triggers import Timer

from gravcomp.twin.encoder import DecoderConfig
from runner import BENCHES, simulate

FILTERS = 16


def numbers(port) -> list[int]:
    """The bytes of a port, the lowest first."""
    return list(int(port.value).to_bytes(FILTERS, "little"))


@cocotb.test()
async def every_filter(dut):
    await Timer(1, "ns")
    configs = [DecoderConfig(filter_samples=samples) for samples in range(FILTERS)]
    assert numbers(dut.out_levels) == [config.shortest_level for config in configs]
    assert numbers(dut.out_periods) == [config.shortest_period for config in configs]


def test_limit_speed_equals_that_of_the_twin():
    bench = BENCHES / "gc_encoder_limits_bench.vhd"
    simulate("gc_encoder_limits_bench", "test_rtl_encoder_pkg", generics={"filters_g": FILTERS}, extra_sources=(bench,))
