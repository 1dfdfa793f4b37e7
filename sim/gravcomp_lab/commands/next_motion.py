"""Does one planned measurement leave one name? Poor logs drawn by seed, planned for, measured again: plan.md.

Seeds follow a first one, by default that of the commit that is measured, until so many sets had a plan.
"""

import warnings
from pathlib import Path

from gravcomp.files import write_atomically
from gravcomp_lab.blind import seed_of_commit


def add_arguments(parser):
    parser.add_argument("--sets", type=int, default=30, help="sets with alternatives and a plan (default 30)")
    parser.add_argument("--first-seed", type=int, help="first seed (default: the commit's hash, first 7 digits)")
    parser.add_argument("--docs", type=Path, help="folder for plan.md")


def run(arguments):
    from tqdm import tqdm

    from gravcomp_lab.blind import next_motion

    warnings.simplefilter("ignore")
    first = seed_of_commit() if arguments.first_seed is None else arguments.first_seed
    outcomes, seed, n_planned = [], first, 0
    with tqdm(total=arguments.sets, desc="planned sets", delay=2) as bar:
        while n_planned < arguments.sets:
            outcome = next_motion.run(seed)
            seed += 1
            if outcome is not None:
                outcomes.append(outcome)
                n_planned += outcome.is_planned
                bar.update(outcome.is_planned)
    page = next_motion.markdown(outcomes, first, seed - first)
    print(page)
    if arguments.docs:
        write_atomically(arguments.docs / "plan.md", page)
