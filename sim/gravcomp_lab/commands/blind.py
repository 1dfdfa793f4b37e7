"""Diagnose data sets whose effects were drawn by seed, then open the answers: blind.md, confusion matrices.

Data come from the analytic model and from the virtual prototype, whose logs stay in --work. So do the outcomes: the
same command goes on where Ctrl-C stopped it, which tells what is done so far.
"""

from pathlib import Path

from gravcomp.files import write_all_atomically
from gravcomp.training import BACKENDS
from gravcomp_lab.blind import seed_of_commit, tally


def add_arguments(parser):
    parser.add_argument("--sets", type=int, default=60, help="seeds of each kind from the model (default 60)")
    parser.add_argument("--prototype-sets", type=int, default=20, help="of each kind from the prototype (default 20)")
    parser.add_argument("--arm-sets", type=int, default=5, help="of each kind from each arm's prototype (default 5)")
    parser.add_argument("--first-seed", type=int, help="first seed (default: the commit's hash, first 7 digits)")
    parser.add_argument("--work", type=Path, default=Path("build/blind"), help="folder for logs and outcomes")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="of joblib (default %(default)s)")
    parser.add_argument("--docs", type=Path, help="folder for blind.md and figures/blind_*.png")


def run(arguments):
    first_seed = seed_of_commit() if arguments.first_seed is None else arguments.first_seed
    todo = tally.tasks(arguments.sets, arguments.prototype_sets, arguments.arm_sets, first_seed)
    outcomes = tally.run_all(todo, arguments.work, arguments.jobs, arguments.backend)
    if len(outcomes) < len(todo):
        print(f"stopped after {len(outcomes)} of {len(todo)} sets; the same command goes on from there")
    by_source = {source: [o for o in outcomes if o.source == source] for source in tally.SOURCES}
    for source, own in by_source.items():
        if not own:
            continue
        print(f"data of {source}, seeds from {first_seed} on")
        for what, value, target, n in tally.summary(own):
            print(f"  {what:48s}{value:7.1f} %  target {target:6s} ({n} sets)")
        print("  after-error over noise, listed, direction known: median {:.3f}, 95th percentile {:.3f}".format(
            *tally.median_and_top(own, "listed")))  # fmt: skip
    if arguments.docs:
        command = (f"gravcomp-lab blind --sets {arguments.sets} --prototype-sets {arguments.prototype_sets} "
                   f"--arm-sets {arguments.arm_sets} --first-seed {first_seed}")  # fmt: skip
        pictures = {arguments.docs / "figures" / f"blind_{source}.png": tally.confusion_png(own)
                    for source, own in by_source.items() if own}  # fmt: skip
        page = tally.markdown(outcomes, first_seed, command, len(todo))
        write_all_atomically({arguments.docs / "blind.md": page, **pictures})
