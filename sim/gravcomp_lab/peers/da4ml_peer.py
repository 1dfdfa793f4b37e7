"""The network by da4ml: fully parallel, constant products as adder graphs (distributed arithmetic).

Every signal and weight has FRACTION bits after the point. Bits are dropped by truncation, with the half LSB that this
costs folded into the bias downstream, as in our core. Inputs in [-1, 1); the pre-activation saturates where the
activation does; outputs in [-2, 2) wrap. There is no clamp, scaling or flag: less work than our core does.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from da4ml.codegen import RTLModel
from da4ml.trace import FixedVariableArray, comb_trace, to_pipeline

from gravcomp.network.activation import gamma
from gravcomp.network.weights import Network
from gravcomp_lab.peers.design import PeerDesign, float_outputs

# 14 bits err three quarters of 1e-3 of full scale at most; more bits would only make the adders longer.
FRACTION = 14
# Integer bits of the pre-activation by activation: [-2, 2) and [-1, 1).
_LIMIT_BITS = {"quadratic": 1, "hard tanh": 0}


def hard_tanh(a: np.ndarray) -> np.ndarray:
    """a clipped to [-1, 1]."""
    return np.clip(a, -1.0, 1.0)


ACTIVATIONS: dict[str, Callable] = {"quadratic": gamma, "hard tanh": hard_tanh}


def generate(network: Network, x: np.ndarray, folder: Path, *, activation: str, cutoff: int) -> PeerDesign:
    """Write the Verilog of the network with an activation of ACTIVATIONS, cutoff adders deep between registers.

    The error is that of da4ml's own model of the adder graph, at inputs x (k, n), each rounded to the input's format.
    """
    graph = adder_graph(network, activation)
    outputs = graph.predict(rounded(x))
    error = np.abs(outputs - float_outputs(network, x, ACTIVATIONS[activation])).max()
    pipeline = to_pipeline(graph, cutoff, verbose=False)
    RTLModel(pipeline, "peer", folder / "da4ml", flavor="verilog", print_latency=False).write()
    # Unused: the wrapper, and a table that looks for its file wherever it is read.
    sources = [
        path
        for path in sorted((folder / "da4ml/src").rglob("*.v"))
        if path.stem not in ("peer_wrapper", "lookup_table")
    ]
    verilog = folder / "peer.v"
    verilog.write_text("\n".join(path.read_text() for path in sources))
    # A register at the input of every stage, and one at the output, which da4ml does not count.
    stages = len(pipeline.solutions)
    return PeerDesign(
        name=f"da4ml {activation}, cutoff {cutoff}",
        top="peer",
        verilog=verilog,
        interval=1,
        latency=stages + 1,
        latency_claimed=stages,
        error=float(error),
        precision=f"{FRACTION} fraction bits everywhere",
    )


def adder_graph(network: Network, activation: str):
    """The adder graph of the network; h is a (1 - |a|/4) or a, whose a is saturated."""
    half = 2.0 ** -(FRACTION + 1)
    sign, integer, fraction = np.tile([[1], [0], [FRACTION]], network.n_axes)
    x = FixedVariableArray.from_kif(sign, integer, fraction)
    total = x @ rounded(network.hidden_weights).T + (rounded(network.hidden_bias) + half)
    h = total.quantize(1, _LIMIT_BITS[activation], FRACTION, overflow_mode="SAT")
    bias = network.output_bias
    output_weights = rounded(network.output_weights)
    if activation == "quadratic":
        h = (h * (-(np.abs(h) * 0.25) + 1)).quantize(1, 0, FRACTION)
        bias = bias + half * output_weights.sum(axis=1)
    y = (h @ output_weights.T + (rounded(bias) + half)).quantize(1, 1, FRACTION)
    return comb_trace(x, y)


def rounded(values: np.ndarray) -> np.ndarray:
    """Values to the nearest with FRACTION bits after the point."""
    return np.rint(values * 2.0**FRACTION) / 2.0**FRACTION
