"""The netlist of an entity, of gates and of the cells of ECP5, is proven equal to its RTL; that of other RTL is not."""

import pytest

from gravcomp_lab.formal.equivalence import netlist_equals
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from runner import RTL

ENTITIES = {
    "gc_synchronizer": {},
    "gc_glitch_filter": {},
    "gc_quad_decoder": {"speed_timeout_g": 1000},
    "gc_speed_meter": {"timeout_g": 1000},
    "gc_crossing_bus": {},
    "gc_crossing_pulse": {},
    "gc_tick": {},
    "gc_timeout": {},
    "gc_brake_sequencer": {},
    "gc_fault_latch": {},
    "gc_clock_monitor": {},
    "gc_parity_guard": {},
    "gc_lockstep": {},
    "gc_brake_permit": {},
    "gc_brake_test": {},
    "gc_brake_feedback": {},
    "gc_ring": {},
    "gc_delay": {},
    "gc_adder_tree": {},
}
TARGETS = ("gates", "ecp5")


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("entity", ENTITIES)
def test_netlist_equals_rtl(entity, target, tmp_path):
    design = to_verilog(rtl_sources(RTL), entity, ENTITIES[entity], tmp_path / "design.v")
    assert netlist_equals(design, design, entity, target, tmp_path)


@pytest.mark.parametrize("target", TARGETS)
def test_netlist_of_another_filter_differs(target, tmp_path):
    four = to_verilog(rtl_sources(RTL), "gc_glitch_filter", {"samples_g": 4}, tmp_path / "four.v")
    three = to_verilog(rtl_sources(RTL), "gc_glitch_filter", {"samples_g": 3}, tmp_path / "three.v")
    assert not netlist_equals(four, three, "gc_glitch_filter", target, tmp_path)
