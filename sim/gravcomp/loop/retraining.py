"""Training a network again on statics that have changed a little, from the weights that it has."""

from dataclasses import replace
from functools import partial

import numpy as np
from tqdm import tqdm

from gravcomp.diagnosis.model import Model
from gravcomp.logs.measurement import Measurement
from gravcomp.network.weights import Network
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.statics import holding_forces_at
from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Fit, Problem, Stop, levenberg_marquardt
from gravcomp.training.scaling import Scaling
from gravcomp.training.training import RIDGE, TrainingSet, one_blas_thread, snapped, workspace_set

N_POSES = 2500
_ROUNDS, _ROUND = 10, Stop(steps=50)
_MARGIN = 1.02  # of the forces over those of the training poses: the bounds of the workspace lie a little beyond


def augmented_set(lacking: Model, p: RobotParameters, seed: int, n_poses: int = N_POSES) -> TrainingSet:
    """Poses of the workspace with the statics and what the model lacked there."""
    poses = workspace_set(n_poses, p, seed)
    data = Measurement(
        name="workspace",
        t_s=np.arange(n_poses, dtype=float),
        q=poses.q_m,
        v=None,
        force=poses.f_n,
        nominal=poses.f_n,
        unit="N",
        position_units=("m",) * poses.q_m.shape[1],
        force_at=partial(holding_forces_at, p=p),
        robot=p,
    )
    return TrainingSet(poses.q_m, poses.f_n + lacking.predict(data))


def retrained(network: Network, data: TrainingSet, p: RobotParameters) -> tuple[Network, Fit]:
    """The network trained on data from its own hidden weights, on the hardware's grid, and its fit in normalised units.

    Normalisation of positions stays; that of forces follows the data. Raises InputError when the hardware cannot hold
    the weights.
    """
    network = _without_offset(network)
    low, high = data.f_n.min(axis=0), data.f_n.max(axis=0)
    scaling = Scaling(network.q_scale_per_m, (high + low) / 2, _MARGIN * (high - low) / 2)
    gamma = ACTIVATIONS["gamma"]
    problem = Problem(scaling.x(data.q_m), scaling.y(data.f_n), network.n_hidden, gamma, ridge=RIDGE)
    hidden = np.c_[network.hidden_weights, network.hidden_bias]
    with one_blas_thread():
        for _ in tqdm(range(_ROUNDS), desc="retraining", delay=2.0):
            fit = levenberg_marquardt(problem, hidden, _ROUND)
            hidden = fit.hidden
            if fit.reason != "steps":
                break
    return snapped(fit, problem, scaling, p), fit


def _without_offset(network: Network) -> Network:
    """The same network with the offset of the positions folded into the hidden biases."""
    bias = network.hidden_bias - network.hidden_weights @ (network.q_offset_m * network.q_scale_per_m)
    return replace(network, hidden_bias=bias, q_offset_m=np.zeros_like(network.q_offset_m))
