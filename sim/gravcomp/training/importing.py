"""A network of another tool, taken over step by step: as it is, with Gamma for tanh, trained further, on the grid."""

import numpy as np

from gravcomp.errors import InputError
from gravcomp.network.activation import gamma
from gravcomp.network.inputs import axis_of_input
from gravcomp.network.onnx_file import Layers
from gravcomp.network.weights import Network
from gravcomp.robot.machine import Machine
from gravcomp.training.fine_tuning import retrained
from gravcomp.training.scaling import workspace_scaling
from gravcomp.training.training import TrainingSet

_ROUNDS = 40  # of 50 steps each: the other activation starts far from where it ends


def import_network(
    layers: Layers, machine: Machine, data: TrainingSet, unseen: TrainingSet, where: str
) -> tuple[Network, dict[str, float]]:
    """The network trained to Gamma on data, on the hardware's grid; RMS error in percent of the RMS effort by step.

    Raises InputError, with where in front, when inputs or outputs are not the machine's, or the weights do not fit.
    """
    n_inputs = len(axis_of_input(machine.inputs))
    if layers.w.shape[1] != n_inputs or len(layers.c) != machine.n_axes:
        raise InputError(
            f"{where}: {layers.w.shape[1]} inputs and {len(layers.c)} outputs, but the machine gives {n_inputs} and "
            f"takes {machine.n_axes}; export that network, or correct [[axis]] of robot.toml"
        )
    start = _scaled(layers.as_tanh(), machine)

    def percent(network: Network, activation=gamma) -> float:
        error = network.forces(unseen.q, activation) - unseen.f
        return 100.0 * float(np.sqrt(np.mean(error**2) / np.mean(unseen.f**2)))

    steps = {f"as imported, with {layers.activation.lower()}": percent(start, np.tanh)}
    steps["with Gamma in its place"] = percent(start)
    network, _ = retrained(start, data, machine.drive, _ROUNDS)
    steps["trained further, on the hardware's grid"] = percent(network)
    return network, steps


def _scaled(layers: Layers, machine: Machine) -> Network:
    """The layers with the normalisation of the machine folded out of them."""
    scaling = workspace_scaling(machine)
    axis = axis_of_input(scaling.inputs)
    w = layers.w / scaling.q_scale[axis]
    return Network(
        hidden_weights=w,
        hidden_bias=layers.b + layers.w @ scaling.q_offset[axis],  # of sine and cosine it is 0
        output_weights=layers.v / scaling.f_scale[:, None],
        output_bias=(layers.c - scaling.f_offset) / scaling.f_scale,
        **vars(scaling),
    )
