"""RTL against the netlist that Yosys makes of it: equal in every state that one register assignment can reach.

Registers are matched by name; every pair of matched signals is then proven equal by induction over eight clocks.
"""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.synthesis.yosys import run_passes, synthesise

# By target, passes on the netlist: its cells become what Yosys' own models are; GHDL's names of intermediate values,
# some bits of which have lost their driver, are no longer matched.
_TARGETS = {
    "gates": ["hierarchy -check -top {top}", "rename -hide w:n*_o w:*.n*_o"],
    "ecp5": ["read_verilog -overwrite +/lattice/cells_sim_ecp5.v", "hierarchy -check -top {top}"],
}
# All registers become plain ones with logic before them.
_LOWER = "proc; flatten; opt_clean; opt -full; memory; dffunmap; opt_clean"
_COMPARE = (
    "design -copy-from gold gold; design -copy-from gate gate; equiv_make gold gate equiv; hierarchy -top equiv; "
    "equiv_simple -undef -seq 3; equiv_induct -undef -seq 8; equiv_status -assert"
)


def netlist_equals(rtl: Path, source: Path, top: str, target: str, out: Path) -> bool:
    """Whether the netlist of module top in one Verilog file (source) is proven equal to top in another (rtl).

    target: gates, of Yosys' own kind, or ecp5. False as well when the proof does not converge. out: folder of
    intermediate files. Raises InputError when Yosys fails.
    """
    netlist = synthesise(source, top, target, out).verilog
    read = {"gold": [f"read_verilog {rtl.resolve()}", "hierarchy -check -top {top}"]}
    read["gate"] = [f"read_verilog {netlist.resolve()}", *_TARGETS[target]]
    passes = []
    for name, reading in read.items():
        passes += [line.format(top=top) for line in reading]
        passes += [*_LOWER.split("; "), f"rename {top} {name}", f"design -stash {name}"]
    try:
        run_passes([*passes, *_COMPARE.split("; ")], out / "equivalence.log")
    except InputError as stop:
        if "unproven $equiv cells" not in str(stop):
            raise
        return False
    return True
