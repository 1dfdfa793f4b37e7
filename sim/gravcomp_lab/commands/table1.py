"""Repeat the paper's Table 1 and write docs/measured/table1.md: training performance against the number of neurons."""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.training import BACKENDS
from gravcomp.training.training import N_TEST_POSES, workspace_set
from gravcomp_lab.paper.table1 import GRADIENT_THRESHOLD, markdown, table1
from gravcomp_lab.shipped import shipped_machine

_HEADER = """# Table 1 of the paper, repeated

Written by `gravcomp-lab table1`. Plain Levenberg-Marquardt, {poses} poses (seed {seed}), best of {starts} starts by
training error. A start stops at a gradient of {threshold} or when the error stands still. Gradient: norm of dMSE/dp
over the normalised parameters, MSE in N². Unseen: {unseen} poses (seed {unseen_seed}). The paper names no unit for
gradient and MSE, and does not say which activation its table was trained with.

"""


def add_arguments(parser):
    parser.add_argument("--starts", type=int, default=24, help="per size (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of poses and starts (default %(default)s)")
    parser.add_argument("--poses", type=int, default=3500, help="training poses (default %(default)s)")
    parser.add_argument("--out", type=Path, default=Path("docs/measured/table1.md"), help="file (default %(default)s)")
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="of joblib (default %(default)s)")


def run(arguments):
    if arguments.starts < 1:
        raise InputError(f"{arguments.starts} starts; give at least 1")
    machine = shipped_machine()
    data = workspace_set(arguments.poses, machine.robot, arguments.seed)
    unseen = workspace_set(N_TEST_POSES, machine.robot, arguments.seed + 1)
    rows = table1(data, unseen, machine, n_starts=arguments.starts, seed=arguments.seed, backend=arguments.backend)
    header = _HEADER.format(
        poses=arguments.poses,
        seed=arguments.seed,
        starts=arguments.starts,
        threshold=GRADIENT_THRESHOLD,
        unseen=N_TEST_POSES,
        unseen_seed=arguments.seed + 1,
    )
    write_atomically(arguments.out, header + markdown(rows))
    print(markdown(rows), end="")
    print(f"{arguments.out}: seed {arguments.seed}")
