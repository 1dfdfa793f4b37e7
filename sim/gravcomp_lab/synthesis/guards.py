"""What the guards of the safety chain cost: cells with each of them off and on, on ECP5."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from gravcomp_lab.synthesis.survey import MULTIPLIER
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import synthesise

Generics = Mapping[str, int | str]

# Of gc_system; the core as small as it gets, so that what is beside it shows.
LANES = 1
_SAFETY = ("two_paths_g", "brake_feedback_g", "brake_test_g", "guard_g")
_SYSTEM_OFF = {"lanes_g": LANES, "loadable_g": "false", "clock_watch_g": 0, "twin_g": "false"}
OFF: dict[str, Generics] = {
    "gc_safety": dict.fromkeys(_SAFETY, "false"),
    "gc_drive": {},
    "gc_system": {**_SYSTEM_OFF, **dict.fromkeys(_SAFETY, "false")},
}
# What is switched on, each for itself and then together; the second core with all of it.
STEPS: dict[str, dict[str, Generics]] = {
    "second path": {"two_paths_g": "true"},
    "read-back": {"brake_feedback_g": "true"},
    "second path, read-back, test": dict.fromkeys(_SAFETY[:3], "true"),
    "parity": {"guard_g": "true"},
    "all of these": dict.fromkeys(_SAFETY, "true"),
}
SYSTEM_STEPS: dict[str, Generics] = {
    "all of these, clock monitor": {**dict.fromkeys(_SAFETY, "true"), "clock_watch_g": 256},
    "and the second core": {**dict.fromkeys(_SAFETY, "true"), "clock_watch_g": 256, "twin_g": "true"},
}
COLUMNS = {"LUT4": "LUT4", "CCU2C": "CCU2C", "TRELLIS_FF": "flip-flops", "MULT18X18D": "multipliers", "DP16KD": "RAM"}


def cases() -> Iterator[tuple[str, str, Generics]]:
    """Entity, what is on, and its generics, in the order of the table."""
    for entity, off in OFF.items():
        yield entity, "nothing", off
        steps = STEPS if entity == "gc_safety" else SYSTEM_STEPS if entity == "gc_system" else {}
        for name, on in steps.items():
            yield entity, name, {**off, **on}


def cells(entity: str, generics: Generics, rtl: Path, out: Path, target: str = "ecp5") -> dict[str, int]:
    """Cells of an entity by type. InputError when a tool fails."""
    verilog = to_verilog(rtl_sources(rtl), entity, generics, out / f"{entity}.v")
    return synthesise(verilog, entity, target, out, mapping=rtl / MULTIPLIER if target == "ecp5" else None).cells


def without_guards(text: str) -> str:
    """VHDL in which every choice that a guard's generic makes is made: the branch of it being off alone is left."""
    guards = "guard_g|two_paths_g|feedback_g|test_g|twin_g|clock_watch_g > 0"
    # By its indentation: a choice may hold others.
    pattern = rf"^( *)(\w+) : if (?:{guards}) generate$.*?^\1else generate$(.*?)^\1end generate \2;$"
    return re.sub(pattern, r"\3", text, flags=re.MULTILINE | re.DOTALL)


def row(entity: str, what: str, counts: Mapping[str, int]) -> str:
    """A line of the table."""
    return f"| {entity} | {what} | {' | '.join(str(counts.get(name, 0)) for name in COLUMNS)} |"


def head() -> str:
    """The first lines of the table."""
    return f"| entity | on | {' | '.join(COLUMNS.values())} |\n|---|---|{'---|' * len(COLUMNS)}"
