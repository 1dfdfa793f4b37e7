"""The network by NNgen: one multiplier at a time, weights and data in a memory beside it, over AXI.

16-bit data and weights, sums of 64 bits. Gamma is none of NNgen's activations; its sigmoid from a table of 4096
entries gives tanh(a) = 2 sigmoid(2 a) - 1, whose factor and offset are folded into the output layer.
"""

import contextlib
import math
from pathlib import Path

import nngen as ng
import numpy as np
import veriloggen as vg
import veriloggen.thread as vthread
import veriloggen.types.axi as axi

from gravcomp.errors import InputError
from gravcomp.network.weights import Network
from gravcomp_lab.peers.design import PeerDesign, float_outputs

# Fraction bits of x, W, a, V and y: the most that 16 bits hold for |W| < 4, |V| < 8, |a| < 16, |y| < 2.
_X, _W, _A, _V, _Y = 15, 13, 11, 12, 14
_TABLE_BITS = 12
# The table spans |2 a| < 8: of the powers of two (others give wrong addresses) the one with the smallest error.
_TABLE_LIMIT = 8.0
_SIGMOID_ONE = 2**15 - 1
_BUS_BITS, _CHUNK_BYTES = 32, 64


def generate(network: Network, x: np.ndarray, folder: Path) -> PeerDesign:
    """Write the Verilog of the network and simulate one inference with NNgen's own test bench (Icarus).

    The error is that of NNgen's own model at inputs x (k, n); the simulation must agree with it. Interval and latency
    are clocks from the start command to the answer that the core is done, over AXI; the next one can start then.
    """
    verilog = folder.resolve() / "peer.v"
    folder.mkdir(parents=True, exist_ok=True)
    codes = np.clip(np.rint(x * 2.0**_X), -(2**15), 2**15 - 1).astype(np.int64)
    outputs = _model(network, codes) / 2.0**_Y
    error = np.abs(outputs - float_outputs(network, x, np.tanh)).max()
    # NNgen and its simulator write files into the working directory.
    with contextlib.chdir(folder):
        _, y = _network(network, 1)
        verilog.write_text(ng.to_verilog([y], "peer", silent=True))
        clocks = _simulated_clocks(network, codes[:1])
    return PeerDesign(
        name="NNgen, table of tanh",
        top="peer",
        verilog=verilog,
        interval=clocks,
        latency=clocks,
        latency_claimed=clocks,
        error=float(error),
        precision=f"16 bits, table of {2**_TABLE_BITS}",
    )


def _network(network: Network, n_poses: int):
    """Input and output operators of the network for n_poses inputs at a time."""
    x = ng.placeholder(dtype=ng.int16, shape=(n_poses, network.n_axes), name="x")
    # The address of the table is truncated: half its step, in a.
    half_step = _TABLE_LIMIT / 2**_TABLE_BITS / 2
    hidden_bias = (network.hidden_bias + half_step) * 2.0 ** (_X + _W)
    h = ng.matmul(
        x,
        _constant(network.hidden_weights * 2.0**_W, ng.int16, "w"),
        bias=_constant(hidden_bias, ng.int32, "b_h"),
        act_func=ng.sigmoid,
        transposed_b=True,
        dtype=ng.int16,
        sum_dtype=ng.int64,
    )
    h.attribute(cshamt_out=_X + _W - _A)
    h.scale_factor = 2.0 ** (_A - 1)  # of 2 a
    h.act_func.lut_addrwidth, h.act_func.lut_clip = _TABLE_BITS, _TABLE_LIMIT
    h.act_func.range_rate = _SIGMOID_ONE / 2**15
    output_bias = (network.output_bias - network.output_weights.sum(axis=1)) * _SIGMOID_ONE * 2.0 ** (_V - 1)
    y = ng.matmul(
        h,
        _constant(network.output_weights * 2.0**_V, ng.int16, "v"),
        bias=_constant(output_bias, ng.int32, "b_o"),
        transposed_b=True,
        dtype=ng.int16,
        sum_dtype=ng.int64,
        name="y",
    )
    y.attribute(cshamt_out=_V + 14 - _Y)
    return x, y


def _constant(values: np.ndarray, dtype, name: str):
    codes = np.rint(values).astype(np.int64)
    if np.abs(codes).max() >= 2 ** (dtype.width - 1):
        raise InputError(f"NNgen: {name} does not fit {dtype.width} bits; compare a network with smaller weights")
    variable = ng.variable(dtype=dtype, shape=codes.shape, name=name)
    variable.set_value(codes)
    return variable


def _model(network: Network, codes: np.ndarray) -> np.ndarray:
    _, y = _network(network, len(codes))
    return ng.eval([y], x=codes)[0]


def _simulated_clocks(network: Network, codes: np.ndarray) -> int:
    """Clocks of an inference in a simulation with the memory model of veriloggen; InputError if it is wrong."""
    x, y = _network(network, 1)
    target = ng.to_veriloggen([y], "peer", silent=True)
    weights = ng.export_ndarray([y], _CHUNK_BYTES)
    weights_address = _next_chunk(x.addr + x.memory_size)
    free_address = _next_chunk(weights_address + len(weights))
    memory = np.zeros(4096, dtype=np.int64)
    axi.set_memory(memory, codes, _BUS_BITS, x.dtype.width, x.addr, 2)
    axi.set_memory(memory, weights, _BUS_BITS, 8, weights_address)
    bench = _bench(target, memory, y, free_address)
    printed = vg.simulation.Simulator(bench, sim="iverilog").run(outputfile="peer.out")
    numbers = [int(line.split()[1]) for line in printed.splitlines() if line.startswith("result")]
    expected = _model(network, codes)[0]
    if numbers[1:] != expected.tolist():
        raise InputError(f"NNgen: its Verilog gives {numbers[1:]}, its model {expected.tolist()}; see {Path.cwd()}")
    return numbers[0]


def _bench(target, memory: np.ndarray, y, free_address: int):
    """Test bench: start the core over AXI-Lite, wait for it, print clocks and outputs. As in NNgen's examples."""
    bench = vg.Module("bench")
    bench.copy_params(target)
    ports = bench.copy_sim_ports(target)
    clk, reset_n = ports["CLK"], ports["RESETN"]
    rst = bench.Wire("RST")
    rst.assign(vg.Not(reset_n))
    ram = axi.AxiMemoryModel(
        bench, "ram", clk, rst, datawidth=_BUS_BITS, memimg=memory, memimg_name="ram.out", memimg_datawidth=_BUS_BITS
    )
    ram.connect(ports, "maxi")
    control = vthread.AXIMLite(bench, "control", clk, rst, noio=True)
    control.connect(ports, "saxi")
    clocks = bench.Reg("clocks", 32, initval=0)
    vg.Seq(bench, "count", clk, rst)(clocks.inc())

    def run():
        # Veriloggen compiles this function to a state machine.
        ng.sim.set_global_addrs(control, free_address)
        began = clocks.value
        ng.sim.start(control)
        ng.sim.wait(control)
        ended = clocks.value
        print("result %d" % (ended - began))  # noqa: UP031
        for axis in range(y.shape[1]):
            print("result %d" % ram.read_word(axis, y.addr, 16))  # noqa: UP031
        vthread.finish()

    vthread.Thread(bench, "run", clk, rst, run).start()
    bench.Instance(target, "peer", params=bench.connect_params(target), ports=bench.connect_ports(target))
    vg.simulation.setup_clock(bench, clk, hperiod=5)
    initial = vg.simulation.setup_reset(bench, reset_n, bench.make_reset(), period=100, polarity="low")
    initial.add(vg.Delay(1_000_000), vg.Systask("finish"))
    return bench


def _next_chunk(address: int) -> int:
    return math.ceil(address / _CHUNK_BYTES) * _CHUNK_BYTES
