"""Print the diagnosis beside other tools on the same blind sets: held-out error, right and wrong names; the page."""

import importlib.util
from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically
from gravcomp_lab.blind import from_model, peers, seed_of_commit

_PAGE = """# The diagnosis beside other tools

`gravcomp-lab peers-diagnosis --sets {sets} --first-seed {seed}`: {n} sets of the analytic model as in the
[blind tally](blind.md), {sets} of each kind, seeds from {seed} on. Each tool has the same training samples and
variables and is judged on the same held-out samples; 1.000 is the noise itself. Names count per set, on all axes
together; times are of one processor.

{table}

Settings: least squares has offset, Coulomb, viscous, Stribeck (at the 0.3 quantile of speed), load, gain, spring and
friction by position at once, and names what a t test has at p < 0.001. PySINDy 2.1 (de Silva et al., 2020) has
polynomials of degree 2 of all variables (position, model, velocity, direction of every axis, time, temperature),
standardised, and STLSQ, its ridge (0.001 to 10) and threshold (0.02 to 0.1 standard deviations) by cross-validation
over four groups of blocks; its terms are no effects and count as no names. Random trees: scikit-learn's ExtraTrees,
200 trees, 3 samples per leaf. MuJoCo's system identification has no robot here: the sets are of the built-in machine,
which is no MuJoCo model, and of single axes.
"""


def add_arguments(parser):
    parser.add_argument("--sets", type=int, default=20, help="seeds of each kind (default %(default)s)")
    parser.add_argument("--first-seed", type=int, help="first seed (default: the commit's hash, first 7 digits)")
    parser.add_argument("--docs", type=Path, help="folder for peers_diagnosis.md")


def run(arguments):
    if importlib.util.find_spec("pysindy") is None:
        raise InputError("pysindy: not installed; start `make peers-diagnosis`")
    seed = seed_of_commit() if arguments.first_seed is None else arguments.first_seed
    cases = [(kind, seed + k) for k in range(arguments.sets) for kind in from_model.CASES]
    results = [peers.run_case(*case) for case in tqdm(cases, desc="sets", disable=None)]
    text = peers.table(results)
    print(f"seeds from {seed} on\n{text}")
    if arguments.docs:
        page = _PAGE.format(sets=arguments.sets, seed=seed, n=len(results), table=text)
        write_all_atomically({arguments.docs / "peers_diagnosis.md": page})
