"""gc_core as Verilog and as netlists passes the tests of tb/test_rtl_core.py, bit for bit, under Icarus."""

import pytest

import test_rtl_core
from gravcomp.synthesis.verilog import rtl_sources, to_verilog
from gravcomp.synthesis.yosys import synthesise
from runner import BUILD, ROOT, RTL, simulate
from test_rtl_core import back_to_back, random_gaps, reset_in_mid_stream  # noqa: F401, cocotb finds them here

GATES = BUILD / "gates"
ECP5_MODELS = ROOT / "tb" / "gates" / "ecp5.v"
ECP5_MULTIPLY = RTL / "ecp5" / "gc_multiply_18_18.v"

# Its interval and latency are those of the VHDL; its speed of simulation is not.
test_rtl_core.BUILD = GATES


def ghdl_verilog(lanes: int):
    """The core in the Verilog that GHDL writes."""
    return to_verilog(rtl_sources(RTL), "gc_core", {"lanes_g": lanes}, GATES / f"gc_core-{lanes}.v")


def run(lanes: int, kind: str, verilog) -> None:
    simulate("gc_core", "test_rtl_gates", generics={"lanes_g": lanes}, label=kind, verilog=verilog)


@pytest.mark.parametrize("lanes", [1, 4, pytest.param(20, marks=[pytest.mark.slow, pytest.mark.gatesim])])
def test_core_as_verilog_of_ghdl_equals_model(lanes):
    run(lanes, "ghdl", [ghdl_verilog(lanes)])


@pytest.mark.slow
@pytest.mark.gatesim
@pytest.mark.parametrize("lanes", [1, 4])
def test_core_as_generic_netlist_equals_model(lanes):
    netlist = synthesise(ghdl_verilog(lanes), "gc_core", "generic", GATES / f"generic-{lanes}")
    run(lanes, "generic", [netlist.verilog])


@pytest.mark.slow
@pytest.mark.gatesim
@pytest.mark.parametrize("lanes", [1, 4])
def test_core_as_ecp5_netlist_equals_model(lanes):
    out = GATES / f"ecp5-{lanes}"
    netlist = synthesise(ghdl_verilog(lanes), "gc_core", "ecp5", out, mapping=ECP5_MULTIPLY)
    run(lanes, "ecp5", [netlist.verilog, ECP5_MODELS])
