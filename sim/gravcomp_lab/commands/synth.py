"""Area and clock of the core per number of lanes, or in the serial form on small parts, with free tools;
docs/measured/synthesis.md and its picture."""

from pathlib import Path

from gravcomp.robot.machine import FORMS, LEAN, PAPER, SERIAL
from gravcomp_lab.benches.core import distinct_lanes
from gravcomp_lab.forms import form_copy
from gravcomp_lab.pages import renew
from gravcomp_lab.simulated.pictures import save_figure
from gravcomp_lab.synthesis.options import add_options, check_options
from gravcomp_lab.synthesis.report import picture, tables
from gravcomp_lab.synthesis.small_parts import small_survey, small_table
from gravcomp_lab.synthesis.survey import survey


def add_arguments(parser):
    add_options(parser)
    parser.add_argument(
        "--lanes", type=int, nargs="+", default=[1, 4, 20], help="neurons per clock, but in the serial form"
    )
    parser.add_argument("--form", choices=FORMS, default=PAPER, help="of the network (default %(default)s)")
    parser.add_argument("--docs", type=Path, help="folder whose synthesis.md and picture are to be renewed")


def run(arguments):
    check_options(arguments)
    lanes, weights, build = distinct_lanes(arguments.lanes), arguments.weights, arguments.build
    if arguments.form == SERIAL:
        return _serial(arguments)
    if arguments.form == LEAN:
        weights, build = form_copy(weights, build, LEAN), build / LEAN
    results = survey(lanes, arguments.rtl, build, arguments.jobs, weights, arguments.backend)
    text, figure = tables(results), picture(results)
    print(text)
    save_figure(figure, build / "synth" / "synthesis.png")
    if arguments.docs and arguments.form == LEAN:
        renew(arguments.docs / "synthesis.md", "synth-lean", text)
    elif arguments.docs:
        renew(arguments.docs / "synthesis.md", "synth", text)
        save_figure(figure, arguments.docs / "figures" / "synthesis.png")


def _serial(arguments) -> None:
    weights = form_copy(arguments.weights, arguments.build, SERIAL)
    text = small_table(small_survey(arguments.rtl, arguments.build / SERIAL / "synth" / weights.name, weights))
    print(text)
    if arguments.docs:
        renew(arguments.docs / "synthesis.md", "synth-serial", text)
