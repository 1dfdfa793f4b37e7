"""Print the operations per inference: counted in NumPy, counted in the running VHDL, and those of the statics."""

import json
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp_lab.paper.operations import count_network_operations, count_statics_operations

KINDS = ("multiplications", "sums")
PAPER = "| paper: statics by its analytic model | | | | | 532 | 8305 |"


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="weights folder")
    parser.add_argument("--rtl", type=Path, default=Path("build/budget-4.json"), help="counts of the simulated core")


def run(arguments):
    try:
        rows = json.loads(arguments.rtl.read_text())
        mults, sums = (sum(row["number"] for row in rows if row["kind"] == kind) for kind in KINDS)
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(f"{arguments.rtl}: no such count, or a damaged one; start `make budget`") from None
    network, statics = (
        count_network_operations(load_network(arguments.weights)),
        count_statics_operations(spheiro_of(load_machine(arguments.weights))),
    )
    print("| what | multiplications | sums | divisions | square roots | trigonometric | all |")
    print("|---|---|---|---|---|---|---|")
    print(f"| network, running VHDL | {mults} | {sums} | 0 | 0 | 0 | {mults + sums} |")
    print(_row("network, NumPy on counting numbers", network))
    print(_row("statics in closed form, from joint positions", statics))
    print(PAPER)
    print("\nA sum of many terms counts as one, as in the paper; theta |a| counts, though it is a shift in hardware.")


def _row(name, count):
    kinds = (count.multiplications, count.sums, count.divisions, count.square_roots, count.trigonometric, count.total)
    return f"| {name} | {' | '.join(str(number) for number in kinds)} |"
