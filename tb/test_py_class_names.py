"""No class name stands for two things, but where both are one thing of two sides, or a name the field has for both."""

import ast
from collections import defaultdict

from codes import ROOT

SIM = ROOT / "sim"
# The prototype has what a candidate of the diagnosis explains, under the name of the effect.
MADE, SOUGHT = "prototype/imperfections.py", "diagnosis/effects/"
SHARED = {
    "Bus",  # registers by address: of a driver, of the server of a serial line
    "Campaign",  # measured on a board, of injected flips
    "Entry",  # of a fit, of a campaign's journal
    "Line",  # a serial one, a straight one
    "Outcome",  # of an injected flip, of a planted fault
    "Plan",  # of the next measurement, of a campaign
    "Port",  # of an entity, between the RTL under Verilator and the robot
    "Range",  # low to high: of an axis, of a parameter that is drawn
    "State",  # of the brakes, as in the registers; of the whole core, as read
    "Step",  # in time, of a campaign's route
}


def test_class_names_stand_for_one_thing():
    where = defaultdict(list)
    for path in sorted(SIM.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef):
                where[node.name].append(path.relative_to(SIM).as_posix())
    twice = {name: files for name, files in where.items() if len(files) > 1}
    effects = {name for name, files in twice.items() if len(files) == 2 and MADE in files[1] and SOUGHT in files[0]}
    assert set(twice) - effects == SHARED, {name: twice[name] for name in set(twice) - effects - SHARED}
