"""The operations of one inference, counted in the running VHDL: 166 multiplications and 43 sums at hidden size 20.

Every multiplier, adder tree, activation and output of the core is watched through its in_valid or out_valid. Leaves the
counts in build/budget.json, from which `make budget` prints its table.
"""

import json
import os
from collections import Counter

import cocotb
import pytest
from cocotb.handle import HierarchyObject
from cocotb.triggers import FallingEdge, Timer

from codes import fixed_network, pack
from gravcomp.core.formats import COUNT_BITS
from gravcomp.network.weights import load_network
from gravcomp_lab.benches.stream import start
from gravcomp_lab.paper.operations import count_network_operations
from runner import BUILD, ROOT, simulate

LAYERS = ("input_scaler", "hidden_lane", "activation", "output_layer", "output_scaler")


def instances(handle, path: str = ""):
    """All (path, ports) below a handle that have an in_valid; GHDL finds names inside generates only by iteration."""
    members = {member._name: member for member in handle}
    if "in_valid" in members:
        yield path, members
    for name, member in members.items():
        if isinstance(member, HierarchyObject):
            yield from instances(member, f"{path}/{name}")


def operations(watched: dict, n_outputs: int) -> Counter:
    """Operations that the core begins in this clock, by kind and layer."""
    count = Counter()
    for path, ports in watched.items():
        layer = next((name for name in LAYERS if name in path), None)
        instance = path.rsplit("/", 1)[1]
        begins = ports["in_valid"].value == 1
        if instance == "i_multiply":
            count["multiplications", layer] += begins
        elif instance == "i_sum":
            count["sums", layer] += begins
        elif instance == "i_activation":
            # theta |a|, a shift in hardware, and its difference from beta
            count["multiplications", layer] += begins
            count["sums", layer] += begins
        elif instance == "i_output_layer":
            # products over lanes and clocks and the bias: one n-ary sum per output
            count["sums", layer] += n_outputs * (ports["out_valid"].value == 1)
    return count


@cocotb.test()
async def one_inference(dut):
    fixed = fixed_network()
    watched = {path: ports for path, ports in instances(dut) if path}
    total = Counter()
    await start(dut)
    dut.in_count.value = pack([1000 * (i + 1) for i in range(fixed.n_axes)], COUNT_BITS)
    dut.in_valid.value = 1
    for _ in range(80):
        # Before the rising edge that begins the operations.
        await Timer(1, "ns")
        total += operations(watched, fixed.n_axes)
        await FallingEdge(dut.clk)
        dut.in_valid.value = 0
    rows = [{"kind": kind, "layer": layer, "number": n} for (kind, layer), n in sorted(total.items())]
    (BUILD / f"budget-{os.environ['LANES_G']}.json").write_text(json.dumps(rows))


@pytest.mark.parametrize("lanes", [1, 4])
def test_core_runs_the_budgeted_operations(lanes):
    simulate("gc_core", "test_rtl_budget", generics={"lanes_g": lanes})
    rows = json.loads((BUILD / f"budget-{lanes}.json").read_text())
    total = {kind: sum(row["number"] for row in rows if row["kind"] == kind) for kind in ("multiplications", "sums")}
    counted = count_network_operations(load_network(ROOT / "weights" / "spheiro"))
    assert total == {"multiplications": counted.multiplications, "sums": counted.sums}
    assert total == {"multiplications": 166, "sums": 43}
