"""gc_brake_sequencer: what no input can do to it inside gc_safety. The rest is tested there, against the twin."""

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from gravcomp.twin.brakes import State
from gravcomp_lab.synthesis.verilog import source_of
from runner import RTL, simulate


def power_up(dut, enable: int) -> None:
    """Healthy, without a reset."""
    for name in ("rst", "clear", "in_fault", "in_carried", "in_tested", "in_test", "cfg_brake_clocks"):
        getattr(dut, name).value = 0
    dut.enable.value, dut.in_healthy.value = enable, 1
    Clock(dut.clk, 10, "ns").start(start_high=False)


@cocotb.test()
async def illegal_code_leads_to_fault(dut):
    power_up(dut, enable=0)
    await RisingEdge(dut.clk)
    assert int(dut.state.value) not in set(State)
    await FallingEdge(dut.clk)
    assert dut.state.value == State.FAULT
    assert int(dut.run.value) == int(dut.brake_release.value) == 0


@cocotb.test()
async def enable_that_is_high_at_power_up_starts_nothing(dut):
    power_up(dut, enable=1)
    for enable, state in [(1, State.BRAKED)] * 4 + [(0, State.BRAKED), (1, State.HOLDING)]:
        dut.enable.value = enable
        await RisingEdge(dut.clk)
        await FallingEdge(dut.clk)
        assert dut.state.value == state


def test_brake_sequencer_needs_an_edge():
    simulate("gc_brake_sequencer", "test_rtl_brake_sequencer", tests="high_at_power_up")


@pytest.mark.parametrize("code", sorted(set(range(8)) - set(State)))
def test_brake_sequencer_survives_illegal_codes(code, tmp_path):
    """The code is that of an upset: in a copy of the entity that powers up with it."""
    text = source_of(RTL, "gc_brake_sequencer").read_text()
    upset = text.replace("safety_state_t := state_braked_c", f'safety_state_t := "{code:03b}"')
    assert upset != text
    copy = tmp_path / "gc_brake_sequencer.vhd"
    copy.write_text(upset)
    simulate("gc_brake_sequencer", "test_rtl_brake_sequencer", extra_sources=(copy,), tests="illegal", label=str(code))
