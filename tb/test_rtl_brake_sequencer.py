"""gc_brake_sequencer: what no input can do to it inside gc_safety. The rest is tested there, against the twin."""

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from gravcomp.system.safety import State
from runner import RTL, simulate


@cocotb.test()
async def illegal_code_leads_to_fault(dut):
    for name in ("rst", "enable", "clear", "in_fault", "in_settled", "cfg_brake_clocks"):
        getattr(dut, name).value = 0
    dut.in_healthy.value = 1
    Clock(dut.clk, 10, "ns").start(start_high=False)
    await RisingEdge(dut.clk)
    assert int(dut.state.value) not in set(State)
    await FallingEdge(dut.clk)
    assert dut.state.value == State.FAULT
    assert dut.run.value == dut.brake_release.value == 0


@pytest.mark.parametrize("code", sorted(set(range(8)) - set(State)))
def test_brake_sequencer_survives_illegal_codes(code, tmp_path):
    """The code is that of an upset: in a copy of the entity that powers up with it."""
    text = (RTL / "gc_brake_sequencer.vhd").read_text()
    upset = text.replace("safety_state_t := state_braked_c", f'safety_state_t := "{code:03b}"')
    assert upset != text
    copy = tmp_path / "gc_brake_sequencer.vhd"
    copy.write_text(upset)
    simulate("gc_brake_sequencer", "test_rtl_brake_sequencer", extra_sources=(copy,), label=str(code))
