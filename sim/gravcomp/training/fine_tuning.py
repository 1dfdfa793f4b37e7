"""Training a network further, from the weights that it has: on other data, or to the activation of the hardware."""

import numpy as np
from tqdm import tqdm

from gravcomp.network.weights import Network
from gravcomp.parallel import one_blas_thread
from gravcomp.robot.machine import Drive
from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Problem, Stop, Trained, levenberg_marquardt
from gravcomp.training.scaling import Scaling, effort_scale
from gravcomp.training.training import RIDGE, TrainingSet, snapped

_ROUNDS, _ROUND = 10, Stop(steps=50)
_MARGIN = 1.02  # of the efforts over those of the training poses: the bounds of the workspace lie a little beyond


def retrained(network: Network, data: TrainingSet, drive: Drive, rounds: int = _ROUNDS) -> tuple[Network, Trained]:
    """The network trained to Gamma on data from its own hidden weights, on the hardware's grid, and its normalised fit.

    Normalisation of positions stays; that of efforts follows the data. At most rounds of 50 steps. Raises InputError
    when the hardware cannot hold the weights.
    """
    low, high = data.f.min(axis=0), data.f.max(axis=0)
    middle = (high + low) / 2
    f_scale = effort_scale(_MARGIN * (high - low) / 2, middle, network.position_units)
    scaling = Scaling(network.q_offset, network.q_scale, middle, f_scale, network.position_units, network.inputs)
    problem = Problem(scaling.x(data.q), scaling.y(data.f), network.n_hidden, ACTIVATIONS["gamma"], ridge=RIDGE)
    hidden = np.c_[network.hidden_weights, network.hidden_bias]
    with one_blas_thread():
        for _ in tqdm(range(rounds), desc="retraining", delay=2.0):
            fit = levenberg_marquardt(problem, hidden, _ROUND)
            hidden = fit.hidden
            if fit.reason != "steps":
                break
    return snapped(fit, problem, scaling, drive), fit
