"""What the commands that synthesise, place and route ask for alike."""

import os
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.parallel import WHERE
from gravcomp_lab.shipped import SPHEIRO


def add_options(parser) -> None:
    """Machine folder, folders, and where runs are."""
    parser.add_argument("--weights", type=Path, default=SPHEIRO, help="machine folder (default: the shipped one)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of simulations and of results")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time")
    parser.add_argument("--backend", choices=WHERE, default=WHERE[0], help="where runs are (default %(default)s)")


def check_options(arguments) -> None:
    """Raise InputError for a number of jobs below 1."""
    if arguments.jobs < 1:
        raise InputError(f"--jobs {arguments.jobs}: need one or more")
