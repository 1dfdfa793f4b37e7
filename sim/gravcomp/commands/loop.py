"""Close the loop: diagnose measured data, put what was found into network and compensator, write their ROMs.

Writes report.json, model.toml and report.html as diagnose does, and before/ and after/ for the RTL, which then runs
on the held-out samples (tb/test_rtl_loop.py); loop-report prints the errors. `make loop` does all three.
"""

from argparse import Namespace
from pathlib import Path

from gravcomp.commands import diagnose as diagnose_command
from gravcomp.measured.csv_reader import read_measurement
from gravcomp.measured.loop import check_robot, close_loop, weights_folder
from gravcomp.robot.parameters import load_parameters


def add_arguments(parser):
    parser.add_argument("data", type=Path, help="measured CSV of the robot")
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="network to start from")
    parser.add_argument("--out", type=Path, default=Path("build/loop"), help="folder (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of held-out blocks and training poses (default 0)")
    parser.add_argument("--holdout", choices=("blocks", "reverse", "last"), default="blocks", help="as in diagnose")


def run(arguments):
    p = load_parameters()
    check_robot(read_measurement(arguments.data, p), arguments.weights)
    found = diagnose_command.run(Namespace(**vars(arguments), model=None))
    closed = close_loop(found, arguments.weights, arguments.out, p, arguments.seed)
    print("\nin hardware:")
    for place, names in (
        ("network, trained again", closed.placement.in_network + closed.corrections),
        ("compensator", closed.placement.in_compensator),
        ("nowhere", closed.placement.nowhere),
    ):
        print(f"  {place}: {', '.join(names) or 'nothing'}")
    print(f"  weights: {weights_folder(arguments.out, 'after')}; {closed.n_samples} held-out samples for the RTL")
