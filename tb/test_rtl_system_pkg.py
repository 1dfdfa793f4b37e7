"""gc_system_pkg: every record comes back from its word whole, and every bit of the word is one bit of the record."""

import cocotb
from cocotb.triggers import Timer

from runner import BENCHES, simulate

RECORDS = ("settings", "state")


@cocotb.test()
async def records_come_back(dut):
    dut.flip.value = 2**20  # none
    await Timer(1, "ns")
    for record in RECORDS:
        assert getattr(dut, f"{record}_equal").value == 1, record


@cocotb.test()
async def every_bit_is_a_bit_of_the_record(dut):
    await Timer(1, "ns")
    bits = {record: int(getattr(dut, f"{record}_bits").value) for record in RECORDS}
    for k in range(max(bits.values())):
        dut.flip.value = k
        await Timer(1, "ns")
        for record, n_bits in bits.items():
            assert getattr(dut, f"{record}_equal").value == int(k >= n_bits), (record, k)
            assert getattr(dut, f"{record}_reversed").value == 1, (record, k)


def test_records_and_words():
    simulate("gc_words_bench", "test_rtl_system_pkg", extra_sources=(BENCHES / "gc_words_bench.vhd",))
