"""Which branches of the VHDL the tests take: every condition seen true and seen false."""

from pathlib import Path

from gravcomp.files import write_atomically
from gravcomp_lab.mutation import branches


def add_arguments(parser):
    parser.add_argument("files", nargs="*", help="test files of tb/, all of the VHDL when there are none")
    parser.add_argument("--root", type=Path, default=Path(), help="folder that holds rtl/ and tb/")
    parser.add_argument("--jobs", type=int, default=2, help="simulations at a time (default 2)")
    parser.add_argument("--out", type=Path, default=Path("build/branches"), help="folder of the simulations")
    parser.add_argument("--docs", type=Path, help="folder for branches.md")


def run(arguments):
    root = arguments.root.resolve()
    conditions, seen = branches.count(root, arguments.out, arguments.files, arguments.jobs)
    not_run = [name for name in branches.test_files(root) if arguments.files and name not in arguments.files]
    table = branches.markdown(conditions, seen, branches.reasons(root / "tb" / "unseen_branches.toml"), not_run)
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "branches.md", table)
