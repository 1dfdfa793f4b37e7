"""Which causes were seen in which states on which axes by tb/test_rtl_safety_cells.py, as a table."""

import json
import re
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.twin.safety import Cause, State

INTRODUCTION = """\
# Causes, states, axes

Written by `make cells` from what `tb/test_rtl_safety_cells.py` saw of gc_safety, clock by clock equal to its twin: axes
on which a cause was present in a state. A cause without axes was seen or not. *Absent* is proven, for every input, by
the assertion `<cause>_is_absent_in_<state>` of `tb/formal/safety.sv`; the test demands each of the other cells.

"""


def add_arguments(parser):
    parser.add_argument("--cells", type=Path, default=Path("build/cells"), help="what the test saw")
    parser.add_argument("--checkers", type=Path, default=Path("tb/formal"), help="folder of the checkers")
    parser.add_argument("--docs", type=Path, help="folder for cells.md")


def run(arguments):
    assertions = (arguments.checkers / "safety.sv").read_text()
    rows, n_reached, n_absent = [], 0, 0
    for cause in Cause:
        path = arguments.cells / f"{cause.name.lower()}.json"
        if not path.exists():
            raise InputError(f"{path}: not found; start `make cells`")
        seen, cells = json.loads(path.read_text()), []
        n_axes = max(map(len, seen.values()))
        for state in State:
            is_absent = re.search(rf"{cause.name.lower()}_is_absent_in_{state.name.lower()} : assert", assertions)
            axes = seen.get(state.name, [])
            numbers = ", ".join(str(axis + 1) for axis in axes)
            cells.append("absent" if is_absent else numbers if n_axes > 1 else "seen" if axes else "**never**")
            n_reached, n_absent = n_reached + len(axes), n_absent + (n_axes if is_absent else 0)
        rows.append(f"| {cause.name.lower()} | {' | '.join(cells)} |")
    head = f"| cause | {' | '.join(state.name for state in State)} |\n|---|{'---|' * len(State)}"
    told = f"\nCells reached: {n_reached}; proven absent: {n_absent}.\n"
    table = "\n".join([head, *rows, told])
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "cells.md", INTRODUCTION + table)
