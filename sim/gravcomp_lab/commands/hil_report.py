"""Print what the runs with the RTL in the loop showed, renew docs/measured/hil.md and its picture."""

from pathlib import Path

from gravcomp_lab.hil.report import picture, stop_table, tracking_table
from gravcomp_lab.hil.runs import FULL, Fault, load
from gravcomp_lab.pages import renew
from gravcomp_lab.simulated.pictures import save_figure


def add_arguments(parser):
    parser.add_argument("--run", type=Path, default=Path("build/hil/full"), help="folder that the simulation wrote")
    parser.add_argument("--docs", type=Path, help="folder of hil.md (default: only print, picture beside the run)")


def run(arguments):
    runs = [(run, load(arguments.run, run)) for run in FULL]
    tracked = [pair for pair in runs if pair[0].fault == Fault.NONE]
    stopped = [pair for pair in runs if pair[0].fault != Fault.NONE]
    tables = {"tracking": tracking_table(tracked), "stops": stop_table(stopped)}
    for part, table in tables.items():
        if arguments.docs:
            renew(arguments.docs / "hil.md", part, table)
        print(f"{table}\n")
    path = (arguments.docs / "figures" if arguments.docs else arguments.run) / "hil.png"
    save_figure(picture(tracked, stopped), path)
    print(f"Picture: {path}")
