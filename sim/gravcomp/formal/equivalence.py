"""RTL against the netlist that Yosys makes of it: equal in every state that one register assignment can reach.

Registers are matched by name; every pair of matched signals is then proven equal by induction over eight clocks.
"""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.synthesis.yosys import run_passes

_READ = (
    "read_verilog {file}; hierarchy -check -top {top}; proc; flatten; opt_clean; opt -full; wreduce; opt_clean -purge; "
    "memory; opt_clean -purge"
)
_COMPARE = (
    "design -copy-from gold gold; design -copy-from gate gate; equiv_make gold gate equiv; hierarchy -top equiv; "
    "equiv_struct -icells; equiv_simple -undef -seq 3; equiv_induct -undef -seq 8; equiv_status -assert"
)


def netlist_equals(rtl: Path, source: Path, top: str, out: Path) -> bool:
    """Whether the gate netlist of module top in one Verilog file (source) is proven equal to top in another (rtl).

    False as well when the proof does not converge. out: folder for the log. Raises InputError when Yosys fails.
    """
    out.mkdir(parents=True, exist_ok=True)
    gold, gate = (_READ.format(file=file.resolve(), top=top) for file in (rtl, source))
    script = f"{gold}; rename {top} gold; design -stash gold; {gate}; synth -flatten -top {top}; rename {top} gate"
    passes = f"{script}; design -stash gate; {_COMPARE}".split("; ")
    try:
        run_passes(passes, out / "equivalence.log")
    except InputError as stop:
        if "unproven $equiv cells" not in str(stop):
            raise
        return False
    return True
