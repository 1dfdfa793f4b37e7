"""Print the operations per inference: counted in NumPy, counted in the running VHDL, and those of the statics."""

from pathlib import Path

from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp_lab.benches.budget import budget_run
from gravcomp_lab.benches.core import LANES
from gravcomp_lab.paper.operations import count_network_operations, count_statics_operations

PAPER = "| paper: statics by its analytic model | | | | | 532 | 8305 |"


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="weights folder")
    parser.add_argument("--lanes", type=int, default=4, choices=LANES, help="neurons per clock (default 4)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of the simulation")


def run(arguments):
    counted = budget_run(arguments.lanes, arguments.rtl, arguments.build, arguments.weights)
    mults, sums = counted["multiplications"], counted["sums"]
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
