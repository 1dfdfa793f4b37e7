"""gc_core as Verilog: as GHDL writes it, and as netlists of gates and of the cells of ECP5."""

from pathlib import Path

from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import synthesise
from runner import BUILD, ROOT, RTL

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
