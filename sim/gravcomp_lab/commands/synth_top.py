"""Area and clocks of whole tops, ports on scan chains, with free tools on ECP5; docs/measured/synthesis.md."""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.robot.machine import LEAN, PAPER
from gravcomp_lab.benches.core import distinct_lanes
from gravcomp_lab.pages import renew
from gravcomp_lab.synthesis.options import add_options, check_options
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
    add_options(parser)
    parser.add_argument("--top", choices=CLOCKS, help="this one alone (default: those of the page)")
    parser.add_argument("--lanes", type=int, nargs="+", default=[1], help="neurons per clock, with --top")
    parser.add_argument("--loadable", action="store_true", help="constants that are loaded, with --top")
    parser.add_argument("--form", choices=(LEAN, PAPER), default=LEAN, help="of the network, with --top")
    parser.add_argument(
        "--speeds", type=int, nargs="+", choices=(6, 7, 8), default=[6], help="speed grades (default 6)"
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[1], help="of the placement (default 1)")
    parser.add_argument("--docs", type=Path, help="folder whose synthesis.md is to be renewed; without --top")


def run(arguments):
    check_options(arguments)
    lanes = distinct_lanes(arguments.lanes)
    if arguments.top and arguments.docs:
        raise InputError("--docs: the page shows all tops; leave --top out")
    tops = PAGE
    if arguments.top:
        tops = [Top(arguments.top, number, arguments.loadable, arguments.form) for number in lanes]
    placed = place_tops(
        tops,
        arguments.weights,
        speeds=sorted(set(arguments.speeds)),
        seeds=sorted(set(arguments.seeds)),
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
