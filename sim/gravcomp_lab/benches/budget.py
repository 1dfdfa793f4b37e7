"""The operations of one inference, counted in the running VHDL.

Every multiplier, adder tree, activation and output of the core is watched through its in_valid or out_valid. What makes
sine and cosine of the axes that turn is counted apart, but for the product that each input of the network costs,
whatever it sees: scale times count, or b cos k and b sin k (gc_sin_cos).
"""

from collections import Counter
from pathlib import Path

import cocotb
from cocotb.handle import HierarchyObject
from cocotb.triggers import FallingEdge, Timer

from gravcomp.core.formats import COUNT_BITS, FixedNetwork
from gravcomp.simulation.measured import hand_over
from gravcomp_lab.benches.bench import run_bench
from gravcomp_lab.benches.codes import fixed_network, pack
from gravcomp_lab.benches.stream import start

LAYERS = ("input_scaler", "phase", "sin_cos", "hidden_lane", "activation", "output_layer", "output_scaler")
APART = ("phase", "sin_cos")
PATIENCE = 1000  # clocks


def instances(handle, path: str = ""):
    """All (path, ports) below a handle that have an in_valid; GHDL finds names inside generates only by iteration."""
    members = {member._name: member for member in handle}
    if "in_valid" in members:
        yield path, members
    for name, member in members.items():
        if isinstance(member, HierarchyObject):
            yield from instances(member, f"{path}/{name}")


def operations(watched: dict, fixed: FixedNetwork) -> Counter:
    """Operations that the core begins in this clock, by kind and layer."""
    count = Counter()
    for path, ports in watched.items():
        layer = next((name for name in LAYERS if name in path), None)
        instance = path.rsplit("/", 1)[1]
        begins = ports["in_valid"].value == 1
        if layer == "sin_cos" and instance == "i_multiply":
            count["multiplications", "sines and cosines"] += begins
            count["sums", layer] += begins
        elif instance in ("i_multiply", "i_radian"):
            count["multiplications", layer] += begins
        elif instance == "i_sum":
            count["sums", layer] += begins
        elif instance == "i_activation" and not fixed.is_lean:
            # theta |a|, a shift in hardware, and its difference from beta
            count["multiplications", layer] += begins
            count["sums", layer] += begins
        elif instance == "i_output_layer":
            # products over lanes and clocks and the bias: one n-ary sum per output
            count["sums", layer] += fixed.n_axes * (ports["out_valid"].value == 1)
    return count


@cocotb.test()
async def one_inference(dut):
    fixed = fixed_network()
    watched = {path: ports for path, ports in instances(dut) if path}
    total = Counter()
    await start(dut)
    dut.in_count.value = pack([1000 * (i + 1) for i in range(fixed.n_axes)], COUNT_BITS)
    dut.in_valid.value = 1
    for _ in range(PATIENCE):
        # Before the rising edge that begins the operations.
        await Timer(1, "ns")
        total += operations(watched, fixed)
        await FallingEdge(dut.clk)
        dut.in_valid.value = 0
        if dut.out_valid.value == 1:
            break
    else:
        raise AssertionError(f"no result in {PATIENCE} clocks")
    hand_over(operations=[[kind, layer, n] for (kind, layer), n in sorted(total.items())])


def budget_run(
    lanes: int, rtl: Path, build: Path, weights: Path, generated: Path | None = None
) -> tuple[dict[str, int], dict[str, int]]:
    """Multiplications and sums of one inference of gc_core with so many lanes, in GHDL, of the network and apart.

    The ROM is that of rtl, or that in generated, made from weights.
    """
    environment = {"WEIGHTS": str(weights.absolute())}
    measured = run_bench("gc_core", __name__, lanes, rtl, build / f"budget-{lanes}", environment, generated=generated)
    rows = measured["operations"]
    return tuple(
        {
            kind: sum(n for own, layer, n in rows if own == kind and (layer in APART) == is_apart)
            for kind in ("multiplications", "sums")
        }
        for is_apart in (False, True)
    )
