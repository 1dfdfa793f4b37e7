"""Find what the model lacks in measured data: effects, their parameters, error before and after.

Writes report.json, model.toml and report.html to the folder of --out. Exit status 0 whatever the verdict.
"""

import argparse
from functools import reduce
from pathlib import Path

from gravcomp.files import check_folder
from gravcomp.logs.units import parse_units

_STEPS = 7


def add_arguments(parser):
    parser.add_argument("data", type=Path, help="measured CSV")
    parser.add_argument("--out", type=Path, required=True, help="folder for report.json, model.toml, report.html")
    parser.add_argument(
        "--robot", type=Path, metavar="FOLDER", help="machine folder, or a model.toml; needless with fm columns"
    )
    parser.add_argument("--also", nargs="+", type=Path, default=[], metavar="LOG",
                        help="further logs of the same machine, such as what plan asked for")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, help="draws the held-out blocks (default 0)")
    parser.add_argument("--units", nargs="+", default=[], metavar="NAME=SIZE",
                        help="size of the machine's own units: permille=0.05nm counts=1e-6m")  # fmt: skip
    parser.add_argument(
        "--holdout", choices=("blocks", "reverse", "last"), default="blocks",
        help="held-out samples: a quarter of the blocks of neighbours; all that axis 1 does moving backward; "
        "the last quarter of the time",
    )  # fmt: skip


def seed(text: str) -> int:
    """A seed as --seed takes it."""
    number = int(text)
    if not 0 <= number < 2**32:
        raise argparse.ArgumentTypeError(f"{text} is no seed; give a whole number from 0 to {2**32 - 1}")
    return number


def run(arguments):
    diagnose_log(arguments, arguments.robot)


def diagnose_log(arguments, robot: Path | None) -> tuple:
    """Diagnose a log, write its report to a folder and print it; the diagnosis, and the model with what was found."""
    from tqdm import tqdm

    from gravcomp.diagnosis.diagnosis import diagnose
    from gravcomp.diagnosis.model import Model, load_model
    from gravcomp.diagnosis.report.folder import write_report
    from gravcomp.diagnosis.report.report import text
    from gravcomp.logs.csv_reader import read_measurement
    from gravcomp.logs.joining import joined

    check_folder(arguments.out)
    model = load_model(robot) if robot else Model()
    units = parse_units(arguments.units)
    logs = [read_measurement(path, model.machine, units) for path in (arguments.data, *arguments.also)]
    data = reduce(joined, logs)
    with tqdm(total=_STEPS, desc="diagnose", delay=2, leave=False, disable=None) as bar:

        def tick(what: str) -> None:
            bar.set_postfix_str(what)
            bar.update()

        found = diagnose(data, model, arguments.seed, arguments.holdout, tick)
    grown, content = write_report(found, model, arguments.out)
    print(text(content, arguments.seed))
    return found, grown
