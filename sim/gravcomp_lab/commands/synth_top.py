"""Area and clocks of whole tops, ports on scan chains, with free tools on ECP5; docs/measured/synthesis.md."""

import os
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.parallel import WHERE
from gravcomp.robot.machine import LEAN, PAPER
from gravcomp_lab.pages import renew
from gravcomp_lab.shipped import SPHEIRO
from gravcomp_lab.synthesis.tops import CLOCKS, HEAD, Top, place_tops, row, slowest

# What the page shows: what a user may instantiate, from the smallest to the default.
PAGE = (
    Top("gc_force_path", 1, False, LEAN),
    Top("gc_force_path", 1, True, LEAN),
    Top("gc_system", 1, False, LEAN),
    Top("gc_system", 1, True, LEAN),
    Top("gc_system", 4, True, LEAN),
    Top("gc_system", 4, True, PAPER),
)


def add_arguments(parser):
    parser.add_argument("--top", choices=CLOCKS, help="this one alone (default: those of the page)")
    parser.add_argument("--lanes", type=int, nargs="+", default=[1], help="neurons per clock, with --top")
    parser.add_argument("--loadable", action="store_true", help="constants that are loaded, with --top")
    parser.add_argument("--form", choices=(LEAN, PAPER), default=LEAN, help="of the network, with --top")
    parser.add_argument("--weights", type=Path, default=SPHEIRO, help="machine folder (default: the shipped one)")
    parser.add_argument(
        "--speeds", type=int, nargs="+", choices=(6, 7, 8), default=[6], help="speed grades (default 6)"
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[1], help="of the placement (default 1)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of results")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time")
    parser.add_argument("--backend", choices=WHERE, default=WHERE[0], help="where runs are (default %(default)s)")
    parser.add_argument("--docs", type=Path, help="folder whose synthesis.md is to be renewed; without --top")


def run(arguments):
    for name in ("jobs", *(["lanes"] if arguments.top else [])):
        values = getattr(arguments, name)
        if min(values if isinstance(values, list) else [values]) < 1:
            raise InputError(f"--{name} {values}: need one or more")
    if arguments.top and arguments.docs:
        raise InputError("--docs: the page shows all tops; leave --top out")
    tops = PAGE
    if arguments.top:
        tops = [Top(arguments.top, lanes, arguments.loadable, arguments.form) for lanes in arguments.lanes]
    placed = place_tops(
        tops,
        arguments.weights,
        speeds=arguments.speeds,
        seeds=arguments.seeds,
        rtl=arguments.rtl,
        build=arguments.build,
        jobs=arguments.jobs,
        backend=arguments.backend,
    )
    paths = [line for found in placed for line in slowest(found)]
    text = "\n".join([HEAD, *map(row, placed), "", "Slowest path of each clock, first seed:", "", *paths, ""])
    print(text)
    if arguments.docs:
        renew(arguments.docs / "synthesis.md", "synth-tops", text)
