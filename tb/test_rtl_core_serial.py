"""gc_core_serial, under the tests of gc_core: equal to the bit-true model, its latency; operations counted; its ROM."""

import cocotb
import pytest
from cocotb.triggers import FallingEdge, Timer

from codes import fixed_network, pack
from gravcomp.core.formats import COUNT_BITS
from gravcomp.network.inputs import POSITION
from gravcomp_lab.benches.stream import start
from machines import shipped_in
from runner import simulate
from support.core import check_serial_core, core_latency, drawn_machine


@cocotb.test()
async def operations_of_one_inference(dut):
    """p n + n + n m products begin and n + m sums are taken, whatever is added for the schedule."""
    fixed = fixed_network()
    n, p, m = fixed.n_hidden, fixed.n_inputs, fixed.n_axes
    await start(dut)
    dut.in_count.value = pack([1000 * (i + 1) for i in range(m)], COUNT_BITS)
    dut.in_valid.value = 1
    products = sums = 0
    for _ in range(core_latency(fixed, 1) + 10):
        await Timer(1, "ns")
        products += int(dut.multiplies.value)
        sums += int(dut.takes_a.value) + int(dut.takes_y.value)
        await FallingEdge(dut.clk)
        dut.in_valid.value = 0
    padding = max(n, 6) - n  # neurons that weigh nothing, whose sum is taken all the same
    assert (products, sums) == (p * n + n + n * m, n + padding + m)


def counted(weights, generated, label: str) -> None:
    options = {"environment": {"WEIGHTS": str(weights)}, "generated": generated, "label": f"counted {label}"}
    simulate("gc_core_serial", "test_rtl_core_serial", **options)


def test_shipped_machine_takes_140_products_and_23_sums():
    counted(*shipped_in("serial"), "shipped")


@pytest.mark.slow
def test_serial_core_equals_model_at_its_latency():
    """149 clocks from counts to forces, and to the next counts."""
    check_serial_core(*shipped_in("serial"), label="serial")


@pytest.mark.parametrize(("n_axes", "n_hidden"), [(1, 4), (2, 7), (5, 1)])
def test_serial_core_takes_its_sizes_from_the_rom(n_axes, n_hidden, tmp_path):
    """With fewer inputs than a neuron has slots, and fewer neurons than the schedule has: padded."""
    machine = drawn_machine((POSITION,) * n_axes, n_hidden, tmp_path, "serial")
    check_serial_core(*machine, label=f"serial-{n_axes}-{n_hidden}")
    counted(*machine, f"{n_axes}-{n_hidden}")


@pytest.mark.parametrize(
    ("entity", "form", "told"),
    [
        ("gc_core_serial", "lean", "gc_core_serial: need a ROM of the form serial, got another; take gc_core"),
        ("gc_core", "serial", "gc_core: need a ROM of the form paper or lean, got serial; take gc_core_serial"),
    ],
)
def test_rom_of_another_form_is_refused(entity, form, told):
    weights, generated = shipped_in(form)
    with pytest.raises(AssertionError, match=told):
        simulate(entity, "test_rtl_core", environment={"WEIGHTS": str(weights), "LANES_G": "1"}, generated=generated,
                 label=f"refused {form}")  # fmt: skip
