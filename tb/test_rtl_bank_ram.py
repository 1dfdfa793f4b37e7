"""gc_bank_ram: one port writes, the other reads with one clock's latency, in the two banks apart."""

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, Timer

from runner import simulate

ADDRESS_BITS, WORD_BITS, CLOCKS = 3, 9, 400


@cocotb.test()
async def words_are_read_as_written(dut):
    """The ports change after the rising edge and the word is sampled just before the next."""
    rng = np.random.default_rng(71)
    Clock(dut.clk, 10, "ns").start(start_high=False)
    memory, expected = {}, None
    for _ in range(CLOCKS):
        await Timer(1, "ns")
        write, write_bank, bank = (int(bit) for bit in rng.integers(0, 2, 3))
        write_addr, addr = (int(address) for address in rng.integers(0, 2**ADDRESS_BITS, 2))
        word = int(rng.integers(0, 2**WORD_BITS))
        dut.in_write.value, dut.in_write_bank.value, dut.in_write_addr.value = write, write_bank, write_addr
        dut.in_word.value, dut.in_bank.value, dut.in_addr.value = word, bank, addr
        await RisingEdge(dut.clk)
        # Values at the edge are those before it.
        if expected is not None:
            assert int(dut.out_word.value) == expected
        # Writing and reading one word at once leaves open what is read.
        is_clash = write and (write_bank, write_addr) == (bank, addr)
        expected = None if is_clash else memory.get((bank, addr))
        if write:
            memory[write_bank, write_addr] = word
    assert len(memory) == 2 ** (ADDRESS_BITS + 1)


def test_bank_ram_reads_what_was_written():
    simulate("gc_bank_ram", "test_rtl_bank_ram", generics={"word_bits_g": WORD_BITS, "address_bits_g": ADDRESS_BITS})
