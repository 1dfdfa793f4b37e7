"""Print the operations per inference: counted in NumPy, counted in the running VHDL, and those of the statics.

Sine and cosine of axes that turn are counted apart from the network; the statics are those of a robot in closed form.
"""

from pathlib import Path

from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.network.inputs import SIN_COS
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import LEAN, load_machine
from gravcomp.robot.spheiro.robot import Spheiro
from gravcomp_lab.benches.budget import budget_run
from gravcomp_lab.benches.core import distinct_lanes
from gravcomp_lab.forms import form_copy
from gravcomp_lab.paper.operations import (
    OperationCount,
    count_network_operations,
    count_statics_operations,
    lean_on_counted,
)

PAPER = "| paper: statics by its analytic model | | | | | 532 | 8305 |"


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="weights folder")
    parser.add_argument("--lanes", type=int, default=4, help="neurons per clock (default 4)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of the simulation")


def run(arguments):
    (lanes,) = distinct_lanes([arguments.lanes])
    counted = budget_run(lanes, arguments.rtl, arguments.build, arguments.weights)
    of_lean = _lean_counts(arguments, lanes)
    of_vhdl = [OperationCount(**numbers) for numbers in counted]
    machine, network = load_machine(arguments.weights), load_network(arguments.weights)
    of_numpy = count_network_operations(network)
    print("| what | multiplications | sums | divisions | square roots | trigonometric | all |")
    print("|---|---|---|---|---|---|---|")
    for what, vhdl, numpy in zip(("network", "sine and cosine"), of_vhdl, of_numpy, strict=True):
        if vhdl.total or numpy.total:
            print(_row(f"{what}, running VHDL", vhdl))
            print(_row(f"{what}, NumPy on counting numbers", numpy))
    for what, found in of_lean.items():
        print(_row(f"network in the lean form, {what}", found))
    if isinstance(machine.robot, Spheiro):
        print(_row("statics in closed form, from joint positions", count_statics_operations(machine.robot.parameters)))
        print(PAPER)
    print("\nA sum of many terms counts as one, as in the paper; theta |a| counts, though it is a shift in hardware.")
    if padding := -network.n_hidden % lanes:
        print(f"The VHDL has {padding} neurons of zero weight more, so that {lanes} lanes divide them.")


def _lean_counts(arguments, lanes: int) -> dict[str, OperationCount]:
    """Of the network in the lean form, which takes positions alone."""
    network = load_network(arguments.weights)
    if SIN_COS in network.inputs:
        return {}
    weights = form_copy(arguments.weights, arguments.build, LEAN)
    generated = arguments.build / "lean" / "generated"
    write_rom(weights, generated)
    counted, _ = budget_run(lanes, arguments.rtl, arguments.build / "lean", weights, generated)
    return {
        "running VHDL": OperationCount(**counted),
        "NumPy on counting numbers": lean_on_counted(network, network.q_offset)[1],
    }


def _row(name, count):
    kinds = (count.multiplications, count.sums, count.divisions, count.square_roots, count.trigonometric, count.total)
    return f"| {name} | {' | '.join(str(number) for number in kinds)} |"
