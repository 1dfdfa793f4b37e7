"""Simulate the robot in the physics engine at the pins of gc_system: servo with and without the network, and faults."""

from pathlib import Path

from gravcomp_lab.cosim.library import build, slow_machine
from gravcomp_lab.hil.loop import hil_run
from gravcomp_lab.hil.report import picture, stop_table, tracking_table
from gravcomp_lab.hil.runs import SETS, Fault
from gravcomp_lab.pages import renew
from gravcomp_lab.shipped import SPHEIRO
from gravcomp_lab.simulated.pictures import save_figure


def add_arguments(parser):
    parser.add_argument("--runs", choices=SETS, default="full", help="how long (default full)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of the simulation")
    parser.add_argument(
        "--docs", type=Path, help="folder of hil.md (default: only print, picture beside the simulation)"
    )


def run(arguments):
    folder = slow_machine(SPHEIRO, arguments.build / "hil" / "spheiro")
    library = build(folder, arguments.rtl, arguments.build / "hil" / "core")
    runs = hil_run(arguments.runs, library, folder)
    tracked = [pair for pair in runs if pair[0].fault == Fault.NONE]
    stopped = [pair for pair in runs if pair[0].fault != Fault.NONE]
    tables = {"tracking": tracking_table(tracked), "stops": stop_table(stopped)}
    for part, table in tables.items():
        if arguments.docs:
            renew(arguments.docs / "hil.md", part, table)
        print(f"{table}\n")
    path = (arguments.docs / "figures" if arguments.docs else arguments.build) / "hil.png"
    save_figure(picture(tracked, stopped), path)
    print(f"Picture: {path}")
