"""Halve and double thresholds of the diagnosis on blind sets of the analytic model, and print what that changes."""

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp_lab.blind import from_model, sensitivity

LAST_TUNED = 200  # seeds below were used to tune; those above are tallied


def add_arguments(parser):
    parser.add_argument(
        "names", nargs="+", metavar="NAME", help="of thresholds.py in gravcomp/diagnosis and gravcomp/logs"
    )
    parser.add_argument("--sets", type=int, default=6, help="seeds of each kind (default %(default)s)")
    parser.add_argument("--first-seed", type=int, default=0, help=f"below {LAST_TUNED} (default %(default)s)")


def run(arguments):
    for name in arguments.names:
        if name not in sensitivity.TABLE:
            raise InputError(f"{name}: no threshold of the diagnosis; give one of {', '.join(sensitivity.TABLE)}")
    if arguments.sets < 1 or not 0 <= arguments.first_seed <= LAST_TUNED - arguments.sets:
        raise InputError(
            f"--first-seed and --sets: seeds from 0 to {LAST_TUNED - 1} are for tuning; give some of those"
        )
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.sets)
    cases = [(kind, seed) for kind in from_model.CASES for seed in seeds]
    print(f"{len(cases)} sets: {', '.join(from_model.CASES)}, seeds {seeds[0]} to {seeds[-1]}", flush=True)
    usual = sensitivity.outcomes(cases)
    for name in tqdm(arguments.names, unit="threshold"):
        for factor in sensitivity.FACTORS:
            with sensitivity.scaled(name, factor):
                other = sensitivity.outcomes(cases)
            print(sensitivity.row(name, factor, usual, other), flush=True)
