"""gc_core as Verilog and as netlists passes the tests of tb/test_rtl_core.py, bit for bit, under Icarus."""

from pathlib import Path

import pytest

from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import synthesise
from runner import BUILD, ROOT, RTL
from test_rtl_core import (  # noqa: F401, cocotb finds them here
    back_to_back,
    check_core,
    random_gaps,
    ready_at_its_interval,
    reset_in_mid_stream,
)

GATES = BUILD / "gates"
ECP5_MODELS = ROOT / "tb" / "gates" / "ecp5.v"
ECP5_MULTIPLY = RTL / "ecp5" / "gc_multiply_18_18.v"


def ghdl_verilog(lanes: int) -> Path:
    """The core in the Verilog that GHDL writes."""
    return to_verilog(rtl_sources(RTL), "gc_core", {"lanes_g": lanes}, GATES / f"gc_core-{lanes}.v")


def netlist(lanes: int, target: str) -> list[Path]:
    """The core after synthesis for a target, with the models of its primitives."""
    is_ecp5 = target == "ecp5"
    mapping = ECP5_MULTIPLY if is_ecp5 else None
    found = synthesise(ghdl_verilog(lanes), "gc_core", target, GATES / f"{target}-{lanes}", mapping=mapping)
    return [found.verilog, ECP5_MODELS] if is_ecp5 else [found.verilog]


def run(lanes: int, kind: str, verilog: list[Path], **environment: str) -> None:
    check_core(lanes, module="test_rtl_gates", label=kind, verilog=verilog, environment=environment)


@pytest.mark.parametrize("lanes", [1, 4, pytest.param(20, marks=[pytest.mark.slow, pytest.mark.gatesim])])
def test_core_as_verilog_of_ghdl_equals_model(lanes):
    run(lanes, "ghdl", [ghdl_verilog(lanes)])


@pytest.mark.slow
@pytest.mark.gatesim
@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("target", ["generic", "ecp5"])
def test_core_as_netlist_equals_model(target, lanes):
    run(lanes, target, netlist(lanes, target), POSES="20")
