"""Diagnose data sets whose effect was drawn by seed, then open the answers: table, docs/blind.md, confusion matrix."""

from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp.measured import tally


def add_arguments(parser):
    parser.add_argument("--sets", type=int, default=100, help="seeds of each kind (default 100)")
    parser.add_argument("--first-seed", type=int, default=1000, help="first seed (default 1000; below 200: tuned on)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--docs", type=Path, help="folder for blind.md and figures/blind_confusion.png")


def run(arguments):
    watch = lambda items, total: tqdm(items, total=total, desc="blind", delay=2)  # noqa: E731
    outcomes = tally.run_all(arguments.sets, arguments.first_seed, arguments.jobs, watch)
    for what, value, target, n in tally.summary(outcomes):
        print(f"{what:45s}{value:7.1f} %  target {target:6s} ({n} sets)")
    print("after-error over noise, listed: median {:.3f}, 95th percentile {:.3f}".format(
        *tally.pooled_ratio(outcomes, "listed")))  # fmt: skip
    if arguments.docs:
        command = f"gravcomp blind --sets {arguments.sets} --first-seed {arguments.first_seed}"
        write_atomically(arguments.docs / "blind.md", tally.markdown(outcomes, arguments.first_seed, command))
        write_atomically(arguments.docs / "figures" / "blind_confusion.png", tally.confusion_png(outcomes))
