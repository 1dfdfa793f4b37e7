"""Whether a fault changes nothing, proven: on GHDL's Verilog of gc_system, as it is built with these generics.

First the texts: with intermediate values numbered by their first appearance the two may be the same. What differs must
be modules of the entity with the fault, each proven equal to its original by Yosys: every register that has a name, and
every port, matched by name and proven by induction over eight clocks. Their initial values must be the same.
"""

import re
import subprocess
import sys
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import RUNNER

TOP = "gc_serial_system"  # holds every entity
CONFIGURATIONS = tuple(
    {"lanes_g": lanes, "loadable_g": loadable} for lanes in (1, 4, 20) for loadable in ("true", "false")
)
TIMEOUT_S = 60.0
_LOWER = (
    "proc; flatten; opt_clean; opt -full; memory -nomap; dffunmap; opt_clean; "
    "rename -hide w:n*_o w:*.n*_o w:n*_q w:*.n*_q"
)
_COMPARE = (
    "design -copy-from gold gold; design -copy-from gate gate; equiv_make gold gate equiv; hierarchy -top equiv; "
    "equiv_struct; equiv_simple -undef -seq 3; equiv_induct -undef -seq 8; equiv_status -assert"
)


def write_originals(rtl: Path, folder: Path) -> None:
    """The Verilog of rtl in each configuration, into a folder, for proof."""
    for number, generics in enumerate(CONFIGURATIONS):
        to_verilog(rtl_sources(rtl), TOP, generics, folder / f"{number}.v")


def proof(originals: Path, mutated: Path, entity: str, work: Path) -> str:
    """How it is proven that the VHDL in the folder mutated, with a fault in the entity, is the original; '' if not.

    originals: folder of write_originals. work: folder of intermediate files.
    """
    proven = set()
    for number, generics in enumerate(CONFIGURATIONS):
        files = originals / f"{number}.v", work / f"{number}.v"
        try:
            to_verilog(rtl_sources(mutated), TOP, generics, files[1])
        except InputError:
            return ""
        gold, gate = (_modules(file.read_text()) for file in files)
        if gold.keys() != gate.keys():
            return ""
        # A module of another entity is what it was: its file is the same, and its name tells its generics.
        own = rf"{entity}(_[\da-f_]+)?" if not entity.endswith("_pkg") else ".*"
        differing = [name for name in gold if gate[name] != gold[name] and re.fullmatch(own, name)]
        if differing and entity.endswith("_pkg"):
            return ""
        for name in differing:
            if name not in proven and (_initial(gold[name]) != _initial(gate[name]) or not _equal(*files, name, work)):
                return ""
            proven.add(name)
    return f"Yosys: {entity} equal, by induction" if proven else "the same netlist"


def _modules(verilog: str) -> dict[str, str]:
    """The text of each module, its intermediate values numbered by their first appearance."""
    found = {}
    for module in re.finditer(r"^module (\w+).*?^endmodule", verilog, re.M | re.S):
        numbers: dict[str, str] = {}
        found[module[1]] = re.sub(
            r"\bn\d+(?=_|\b)", lambda n, known=numbers: known.setdefault(n[0], f"n{len(known)}"), module[0]
        )
    return found


def _initial(module: str) -> list[str]:
    return sorted(re.findall(r"initial\s+\w+ = (.*?);", module))


def _equal(gold: Path, gate: Path, top: str, work: Path) -> bool:
    passes = []
    for name, file in (("gold", gold), ("gate", gate)):
        passes += [f"read_verilog {file}", f"hierarchy -check -top {top}", *_LOWER.split("; ")]
        passes += [f"rename {top} {name}", f"design -stash {name}"]
    script = work / "equal.ys"
    script.write_text("\n".join([*passes, *_COMPARE.split("; ")]) + "\n")
    command = [sys.executable, "-c", RUNNER, str(script)]
    try:
        done = subprocess.run(command, cwd=work, capture_output=True, check=False, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0
