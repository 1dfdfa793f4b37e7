"""Whether a fault changes nothing, proven: on GHDL's Verilog of every top that holds the entity, for these generics.

First the texts: with intermediate values numbered by their first appearance the two may be the same. What differs must
be modules of the entity with the fault, each proven equal to its original by Yosys: every register that has a name, and
every port, matched by name and proven by induction over eight clocks, with the same initial values; or, where registers
differ, every port by property-directed reachability from power-up on. Of an entity that none of them holds nothing is
proven.
"""

import contextlib
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.formal.claims import CLAIMS
from gravcomp_lab.formal.model_check import differs_soon, same_at_ports, write_miter
from gravcomp_lab.synthesis.verilog import analysed, handwritten_sources, rtl_sources, synthesised
from gravcomp_lab.synthesis.yosys import RUNNER

TOP = "gc_serial_system"
_GUARDS = ("two_paths_g", "brake_feedback_g", "brake_test_g", "guard_g", "twin_g")
SYSTEMS: tuple[Mapping[str, int | str], ...] = (
    *({"lanes_g": lanes, "loadable_g": loadable} for lanes in (1, 4, 20) for loadable in ("true", "false")),
    {"lanes_g": 4, **dict.fromkeys(_GUARDS, "true")},
)
TIMEOUT_S = 60.0
BMC_TIMEOUT_S, PDR_TIMEOUT_S = 10, 30
_LOWER = (
    "proc; flatten; opt_clean; opt -full; memory -nomap; dffunmap; opt_clean; "
    "rename -hide w:n*_o w:*.n*_o w:n*_q w:*.n*_q"
)
_COMPARE = (
    "design -copy-from gold gold; design -copy-from gate gate; equiv_make gold gate equiv; hierarchy -top equiv; "
    "equiv_struct; equiv_simple -undef -seq 3; equiv_induct -undef -seq 8; equiv_status -assert"
)


def write_originals(rtl: Path, folder: Path) -> None:
    """The Verilog of rtl into a folder, for proof: the system as of SYSTEMS; each entity that none of them holds by
    itself, with its defaults and with the generics of the claims about it.
    """
    with analysed(rtl_sources(rtl)) as library:
        for generics in SYSTEMS:
            _write(library, TOP, generics, folder)
        held = {module for file in folder.glob("*.v") for module in _modules(file.read_text())}
        for entity in _entities(rtl):
            if not any(_is_of(entity, module) for module in held):
                for generics in ({}, *(claim.generics for claim in CLAIMS if claim.entity == entity)):
                    # What only another machine's ROM uses may have no netlist with this one: nothing is proven of it.
                    with contextlib.suppress(InputError):
                        _write(library, entity, generics, folder)


def _entities(rtl: Path) -> list[str]:
    sources = handwritten_sources(rtl).items()
    return [name for name, file in sources if re.search(rf"^entity {name} is$", file.read_text(), re.MULTILINE)]


def _write(library: str, top: str, generics: Mapping[str, int | str], folder: Path) -> Path:
    """The Verilog of a top, in a file whose name tells it and its generics."""
    name = "-".join([top, *(f"{name}={value}" for name, value in generics.items())])
    return synthesised(library, top, generics, folder / f"{name}.v")


def _is_of(entity: str, module: str) -> bool:
    """Whether a module is an entity; behind the name stands what tells its generics."""
    return re.fullmatch(rf"{entity}(_[\da-f_]+)?", module) is not None


def proof(originals: Path, mutated: Path, entity: str, work: Path) -> str:
    """How it is proven that the VHDL in the folder mutated, with a fault in the entity, is the original; '' if not.

    originals: folder of write_originals. work: folder of intermediate files.
    """
    with contextlib.suppress(InputError), analysed(rtl_sources(mutated)) as library:
        return _proof(originals, library, entity, work)
    return ""


def _proof(originals: Path, library: str, entity: str, work: Path) -> str:
    """As of proof, of the analysed VHDL with the fault; InputError when GHDL refuses."""
    proven, is_package, is_held, by_register = set(), entity.endswith("_pkg"), False, True
    for original in sorted(originals.glob("*.v")):
        gold = _modules(original.read_text())
        # A module of another entity is what it was: its file is the same, and its name tells its generics.
        own = [module for module in gold if is_package or _is_of(entity, module)]
        if not own:
            continue
        is_held = True
        top, *settings = original.stem.split("-")
        changed = _write(library, top, dict(setting.split("=") for setting in settings), work)
        gate = _modules(changed.read_text())
        if gold.keys() != gate.keys():
            return ""
        differing = [module for module in own if _numbered(gate[module]) != _numbered(gold[module])]
        if differing and is_package:
            return ""
        for module in [module for module in differing if module not in proven]:
            miter = write_miter(original, changed, module, work, timeout_s=TIMEOUT_S)
            same_start = _initial(gold[module]) == _initial(gate[module])
            if differs_soon(miter, BMC_TIMEOUT_S):
                return ""
            if not (same_start and _equal(original, changed, module, work)):
                by_register = False
                if not same_at_ports(miter, PDR_TIMEOUT_S):
                    return ""
            proven.add(module)
    if proven:
        return f"Yosys: {entity} equal, by induction" if by_register else f"ABC: {entity} equal at its ports, by PDR"
    return "the same netlist" if is_held else ""


def _modules(verilog: str) -> dict[str, str]:
    """The text of each module."""
    return {found[1]: found[0] for found in re.finditer(r"^module (\w+).*?^endmodule", verilog, re.M | re.S)}


def _numbered(module: str) -> str:
    """The text of a module, its intermediate values numbered by their first appearance."""
    numbers: dict[str, str] = {}
    return re.sub(r"\bn\d+(?=_|\b)", lambda n: numbers.setdefault(n[0], f"n{len(numbers)}"), module)


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
