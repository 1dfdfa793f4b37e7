"""Cells of gc_safety, gc_drive and gc_system with the guards off and on; a table in docs/guide/safety.md."""

from pathlib import Path

from tqdm import tqdm

from gravcomp_lab.pages import renew
from gravcomp_lab.synthesis import guards


def add_arguments(parser):
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--out", type=Path, default=Path("build/guards"), help="folder of netlists")
    parser.add_argument("--docs", type=Path, help="folder whose safety.md is to be renewed")


def run(arguments):
    rows = [
        guards.row(entity, what, guards.cells(entity, generics, arguments.rtl, arguments.out / f"{entity}-{k}"))
        for k, (entity, what, generics) in enumerate(tqdm(list(guards.cases()), desc="guards"))
    ]
    table = "\n".join([guards.head(), *rows])
    print(table)
    if arguments.docs:
        renew(arguments.docs / "safety.md", "guards", table)
