"""Close the loop: diagnose measured data, put what was found into network and compensator, write their ROMs.

Writes report.json, model.toml and report.html as diagnose does, and before/ and after/ for the RTL, which then runs
on the held-out samples (tb/test_rtl_loop.py); loop-report prints the errors. `make loop` does all three. after/weights
is a weights folder as any other, and is copied to the folder of --save.
"""

import hashlib
from pathlib import Path

from gravcomp.commands import diagnose as diagnose_command
from gravcomp.core.provenance import write_provenance
from gravcomp.diagnosis.model import Model, load_model
from gravcomp.diagnosis.report import report
from gravcomp.files import write_all_atomically
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.units import parse_units
from gravcomp.loop.loop import check_robot, close_loop, weights_folder


def add_arguments(parser):
    parser.add_argument("data", type=Path, help="measured CSV of the robot")
    parser.add_argument("--model", type=Path, help="the robot's TOML, or a model.toml; default: the nominal robot")
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="network of that model")
    parser.add_argument("--out", type=Path, default=Path("build/loop"), help="folder (default %(default)s)")
    parser.add_argument("--save", type=Path, help="weights folder to keep the result in, for make rom WEIGHTS=...")
    parser.add_argument("--seed", type=diagnose_command.seed, default=0, help="of held-out blocks, training poses")
    parser.add_argument("--units", nargs="+", default=[], metavar="NAME=SIZE", help="as in diagnose")
    parser.add_argument("--holdout", choices=("blocks", "reverse", "last"), default="blocks", help="as in diagnose")


def run(arguments):
    model = load_model(arguments.model) if arguments.model else Model()
    check_robot(read_measurement(arguments.data, model.robot, parse_units(arguments.units)), arguments.weights)
    found, grown = diagnose_command.run(arguments)
    closed = close_loop(found, grown, arguments.weights, arguments.out, arguments.seed)
    result = weights_folder(arguments.out, "after")
    content = report(found)
    write_provenance(
        result,
        command=f"gravcomp loop {arguments.data} --weights {arguments.weights} --seed {arguments.seed} "
        f"--holdout {arguments.holdout}" + (f" --model {arguments.model}" if arguments.model else ""),
        data={"log": arguments.data.name, "sha256": hashlib.sha256(arguments.data.read_bytes()).hexdigest()},
        metrics={f"model_{when}": content[when] for when in ("before", "after")},
    )
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
    print(f"  weights: {result}; {closed.n_samples} held-out samples for the RTL")
