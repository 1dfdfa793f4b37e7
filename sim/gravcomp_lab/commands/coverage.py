"""Count which statements of the VHDL the tests run."""

from pathlib import Path

from gravcomp.files import write_atomically
from gravcomp_lab.mutation import coverage


def add_arguments(parser):
    parser.add_argument("--root", type=Path, default=Path(), help="folder that holds rtl/ and tb/")
    parser.add_argument("--out", type=Path, default=Path("build/coverage"), help="folder of the simulations")
    parser.add_argument("--jobs", type=int, default=2, help="simulations at a time (default 2)")
    parser.add_argument("--docs", type=Path, help="folder for coverage.md")


def run(arguments):
    root = arguments.root.resolve()
    coverages = coverage.count(root, arguments.out.resolve(), arguments.jobs)
    table = coverage.markdown(coverages, coverage.reasons(root / "tb" / "uncovered_statements.toml"))
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "coverage.md", table)
