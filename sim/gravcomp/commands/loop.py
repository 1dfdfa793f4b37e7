"""Close the loop: diagnose measured data, put what was found into network and compensator, write their ROMs.

Writes report.json, model.toml and report.html as diagnose does, and before/ and after/, each a machine folder and its
VHDL packages; prints the errors on held-out samples before and after. after/weights is a machine folder as any other,
and is copied to the folder of --save: the next loop starts from it.
"""

import hashlib
from pathlib import Path

from gravcomp.commands.diagnose import diagnose_log, seed
from gravcomp.files import check_folder, write_all_atomically
from gravcomp.logs.units import parse_units


def add_arguments(parser):
    parser.add_argument("data", type=Path, help="measured CSV of the robot")
    parser.add_argument("--weights", type=Path, required=True, metavar="FOLDER", help="machine folder of the robot")
    parser.add_argument("--out", type=Path, default=Path("build/loop"), help="folder (default %(default)s)")
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="machine folder to keep the result in")
    parser.add_argument("--seed", type=seed, default=0, help="of held-out blocks and training poses (default 0)")
    parser.add_argument("--units", nargs="+", default=[], metavar="NAME=SIZE", help="as in diagnose")
    parser.add_argument("--holdout", choices=("blocks", "reverse", "last"), default="blocks", help="as in diagnose")
    parser.set_defaults(also=[])


def run(arguments):
    from gravcomp.logs.csv_reader import read_measurement
    from gravcomp.loop.loop import check_robot, close_loop, error_head, error_rows, loop_errors, weights_folder
    from gravcomp.robot.machine import load_machine

    for folder in filter(None, (arguments.out, arguments.save)):
        check_folder(folder)
    machine, units = load_machine(arguments.weights), parse_units(arguments.units)
    check_robot(read_measurement(arguments.data, machine, units), arguments.weights)
    found, grown = diagnose_log(arguments, arguments.weights)
    command = (
        f"gravcomp loop {arguments.data} --weights {arguments.weights} --seed {arguments.seed} "
        f"--holdout {arguments.holdout}"
    )
    log = {"log": arguments.data.name, "sha256": hashlib.sha256(arguments.data.read_bytes()).hexdigest()}
    closed = close_loop(found, grown, arguments.weights, arguments.out, arguments.seed, command, log)
    result = weights_folder(arguments.out, "after")
    if arguments.save:
        write_all_atomically({arguments.save / path.name: path.read_bytes() for path in result.iterdir()})
        result = arguments.save
    print("\nin hardware:")
    for place, names in (
        ("network, trained again", closed.placement.in_network + closed.corrections),
        ("compensator", closed.placement.in_compensator),
        ("nowhere", closed.placement.nowhere),
    ):
        print(f"  {place}: {', '.join(names) or 'nothing'}")
    print(f"  weights: {result}\n")
    print(f"{error_head(machine.effort_unit)}\n{error_rows(loop_errors(arguments.out))}\n")
    noise = f"{found.noise_floor:.3f} {machine.effort_unit} RMS"
    print(f"{closed.n_samples} held-out samples; noise of the measurement: {noise}")
