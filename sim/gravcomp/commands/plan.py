"""Plan the shortest next measurement that tells apart what a report could not: poses and approach directions, as CSV.

Reads the log and the report of its diagnosis. Measure the rows in their order, log them as the first log, then
diagnose both: gravcomp diagnose LOG --also NEXT.
"""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.logs.units import parse_units


def add_arguments(parser):
    parser.add_argument("data", type=Path, help="the log that was diagnosed")
    parser.add_argument("--report", type=Path, required=True, help="folder that diagnose wrote for it")
    parser.add_argument("--robot", type=Path, metavar="FOLDER", help="machine folder or model.toml, as for diagnose")
    parser.add_argument("--units", nargs="+", default=[], metavar="NAME=SIZE", help="as for diagnose")
    parser.add_argument("--out", type=Path, help="CSV to write (default: plan.csv in the folder of the report)")
    for name, what in (("low", "least position"), ("high", "largest position"), ("speed", "largest speed")):
        parser.add_argument(f"--{name}", nargs="+", type=float, metavar="VALUE",
                            help=f"{what} of each axis, m or rad (default: of the log, or of the machine)")  # fmt: skip


def run(arguments):
    from gravcomp.diagnosis.model import Model, load_model
    from gravcomp.diagnosis.plan.plan import plan
    from gravcomp.diagnosis.plan.planned import of_report, plan_csv, reach_of, words
    from gravcomp.logs.csv_reader import read_measurement

    model = load_model(arguments.robot) if arguments.robot else Model()
    data = read_measurement(arguments.data, model.machine, parse_units(arguments.units))
    data, rivals, noise = of_report(data, model, arguments.report / "report.json")
    if not rivals:
        print("the report has no alternatives that a measurement could tell apart; nothing to plan")
        return
    found = plan(data, rivals, noise, reach_of(data, arguments.low, arguments.high, arguments.speed))
    out = arguments.out or arguments.report / "plan.csv"
    if out.resolve() == arguments.data.resolve():
        raise InputError(f"{out}: that is the log; give another file by --out")
    lines = words(found, noise)
    if found.rows is not None:
        write_atomically(out, plan_csv(found, lines[0]))
        lines.append(f"{out}: measure these rows, log them as {arguments.data.name}, then gravcomp diagnose "
                     f"{arguments.data} --also NEXT.csv --out ...")  # fmt: skip
    print("\n".join(lines))
