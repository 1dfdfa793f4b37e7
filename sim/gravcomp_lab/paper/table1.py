"""The paper's Table 1 repeated: training performance of networks of several sizes, on 3500 poses.

Plain Levenberg-Marquardt from random starts, stopped by the gradient as in the paper. The row that the paper lacks: a
network trained with tanh and run with Gamma, as the paper's FPGA runs it.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.parallel import run_parallel
from gravcomp.robot.machine import Machine
from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Problem, Stop, Trained, levenberg_marquardt
from gravcomp.training.scaling import workspace_scaling
from gravcomp.training.search import random_hidden
from gravcomp.training.training import RIDGE, TrainingSet, as_network, mean_square_error

GRADIENT_THRESHOLD = 0.009
# Neurons: gradient at the stop and mean square error, as printed in the paper. It gives no unit for either.
PAPER = {15: (0.0090, 0.0429), 20: (0.0080, 0.0263), 25: (0.0500, 0.0268), 30: (0.0072, 0.0314), 40: (0.0088, 0.0198)}
_MAX_STEPS = 1000


@dataclass(frozen=True)
class TrainedRow:
    """One trained network: gradient (norm of dMSE/dp, N^2), mean square errors on training and unseen poses, N^2."""

    n_hidden: int
    trained_with: str
    run_with: str
    gradient_n2: float
    train_mse_n2: float
    test_mse_n2: float


def table1(
    data: TrainingSet, unseen: TrainingSet, machine: Machine, *, n_starts: int, seed: int, backend: str
) -> list[TrainedRow]:
    """Rows of the paper's sizes trained with Gamma, then 20 neurons trained with tanh and run with either.

    The best of n_starts by training error stands for a size. Raises InputError when the backend cannot start.
    """
    scaling = workspace_scaling(machine)
    x, y = scaling.x(data.q), scaling.y(data.f)
    f_scale_n = float(scaling.f_scale[0])  # of every axis: the robot is symmetric
    threshold = GRADIENT_THRESHOLD / f_scale_n**2
    cases = [(n_hidden, "gamma") for n_hidden in PAPER] + [(20, "tanh")]
    seeds = np.random.SeedSequence(seed).spawn(n_starts)
    arguments = [(x, y, n_hidden, name, threshold, s) for n_hidden, name in cases for s in seeds]
    fits = run_parallel(plain_start, arguments, backend, "table 1")
    rows = []
    for k, (n_hidden, name) in enumerate(cases):
        fit = min(fits[k * n_starts : (k + 1) * n_starts], key=lambda fit: fit.mse)
        network = as_network(fit.hidden, fit.output, scaling)
        gradient_n2 = fit.gradient * f_scale_n**2
        for run_with in sorted({name, "gamma"}, reverse=True):
            errors = [mean_square_error(network, poses, run_with) for poses in (data, unseen)]
            rows.append(TrainedRow(n_hidden, name, run_with, gradient_n2, *errors))
    return rows


def plain_start(x, y, n_hidden: int, activation: str, threshold: float, seed) -> Trained:
    """One random start, all parameters free, stopped by the gradient; no symmetry and no search."""
    hidden = random_hidden(n_hidden, x.shape[1], np.random.default_rng(seed))
    problem = Problem(x, y, n_hidden, ACTIVATIONS[activation], None, RIDGE)
    return levenberg_marquardt(problem, hidden, Stop(gradient=threshold, steps=_MAX_STEPS))


def markdown(rows: list[TrainedRow]) -> str:
    """The rows as a Markdown table, the paper's figures beside those of the same size."""
    lines = [
        "| neurons | trained with | run with | gradient, paper | gradient | MSE, paper | MSE, training poses (N²) "
        "| MSE, unseen poses (N²) | RMS, unseen poses (N) |",
        "|--:|--|--|--:|--:|--:|--:|--:|--:|",
    ]
    for row in rows:
        is_paper = row.trained_with == row.run_with == "gamma"
        paper = [f"{value:.4f}" for value in PAPER[row.n_hidden]] if is_paper else ["", ""]
        lines.append(
            f"| {row.n_hidden} | {row.trained_with} | {row.run_with} | {paper[0]} | {row.gradient_n2:.4f} | {paper[1]} "
            f"| {row.train_mse_n2:.4g} | {row.test_mse_n2:.4g} | {np.sqrt(row.test_mse_n2):.3f} |"
        )
    return "\n".join(lines) + "\n"
