"""Put the table and the picture of a sweep, as `gravcomp train --hidden 8,12,20` wrote them, into docs/measured."""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp_lab.pages import renew

TABLE, PICTURE = "sweep.md", "sweep.png"


def add_arguments(parser):
    parser.add_argument("sweep", type=Path, metavar="FOLDER", help=f"with {TABLE} and {PICTURE}")
    parser.add_argument("--docs", type=Path, required=True, help="folder whose machines.md is to be renewed")


def run(arguments):
    try:
        table = (arguments.sweep / TABLE).read_text(encoding="utf-8")
        picture = (arguments.sweep / PICTURE).read_bytes()
    except OSError as error:
        raise InputError(f"{error.filename}: not there; give the --out of a sweep of gravcomp train") from None
    renew(arguments.docs / "machines.md", "sweep", table)
    write_atomically(arguments.docs / "figures" / PICTURE, picture)
