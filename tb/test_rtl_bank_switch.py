"""gc_bank_switch: swaps only while no inference is under way, holds new ones meanwhile, one clock of reset after."""

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from runner import simulate

CRC = {1: 0x1234ABCD, 2: 0xFFFFFFFF}


@cocotb.test()
async def random_commands(dut):
    """Every output in every clock is that of the rules, written down anew; inferences take 1 to 40 clocks."""
    rng = np.random.default_rng(71)
    Clock(dut.clk, 10, "ns").start(start_high=False)
    dut.rst.value = 1
    for port in ("in_accept", "in_bank", "in_crc", "load_rom", "load_begin", "in_start", "in_done"):
        getattr(dut, port).value = 0
    for _ in range(3):
        await FallingEdge(dut.clk)
    bank, crc, waiting, next_bank, restart, under_way, swaps = 0, 0, False, 0, True, [], 0
    for clock in range(20_000):
        assert int(dut.out_bank.value) == bank
        assert int(dut.sts_crc.value) == crc
        assert int(dut.sts_waiting.value) == waiting
        assert int(dut.out_restart.value) == restart
        assert int(dut.out_hold.value) == (waiting or restart)
        accept, rom, begin, rst = rng.random(4) < (0.02, 0.01, 0.01, 0.003)
        offered = 1 + int(rng.integers(2))
        starts = not (waiting or restart) and rng.random() < 0.7
        done = bool(under_way) and under_way[0] <= clock
        dut.in_accept.value, dut.in_bank.value, dut.in_crc.value = int(accept), offered, CRC[offered]
        dut.load_rom.value, dut.load_begin.value, dut.rst.value = int(rom), int(begin), int(rst)
        dut.in_start.value, dut.in_done.value = int(starts), int(done)
        swap = waiting and not under_way and not begin
        restart = bool(swap or rst)
        if swap:
            bank, crc, waiting = next_bank, CRC[offered] if next_bank else 0, False
            swaps += 1
        if accept or rom:
            waiting, next_bank = True, 0 if rom else offered
        if begin or rst:
            waiting = False
        under_way = under_way[done:] + ([max([clock + int(rng.integers(1, 41)), *under_way])] if starts else [])
        if rst:
            bank, crc, under_way = 0, 0, []
        await FallingEdge(dut.clk)
    assert swaps > 100


def test_bank_switch_keeps_its_rules():
    simulate("gc_bank_switch", "test_rtl_bank_switch")
