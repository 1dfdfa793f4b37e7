"""What a peer delivers, and the inputs on which its error is measured."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.network.weights import Network
from gravcomp.robot.machine import Machine


@dataclass(frozen=True)
class PeerDesign:
    """A network in Verilog, written by another tool.

    name: tool and variant. top: module in the file verilog. interval, latency: clocks between inputs, and from an
    input at the ports to its output there; latency_claimed: clocks as the tool counts them. error: largest distance
    from the float network with the same activation, in full scale of an output (y = 1). precision: formats, in words.
    """

    name: str
    top: str
    verilog: Path
    interval: int
    latency: int
    latency_claimed: int
    error: float
    precision: str


def workspace_positions(machine: Machine, n_poses: int, seed: int) -> np.ndarray:
    """Joint positions (n_poses, n), m or rad, at random poses of the workspace."""
    return machine.robot.workspace(n_poses, seed)


def normalised_inputs(network: Network, machine: Machine, n_poses: int, seed: int) -> np.ndarray:
    """Inputs x (n_poses, n) of the network, in (-1, 1), at random poses of the workspace."""
    return (workspace_positions(machine, n_poses, seed) - network.q_offset) * network.q_scale


def float_outputs(network: Network, x: np.ndarray, activation: Callable) -> np.ndarray:
    """Outputs y (k, n) of the float network with this activation at inputs x (k, n), without scaling."""
    hidden = activation(x @ network.hidden_weights.T + network.hidden_bias)
    return hidden @ network.output_weights.T + network.output_bias
