"""gc_activation: Gamma, bit-true for every input code."""

import cocotb
import numpy as np
import pytest

from codes import pack, unpack
from gravcomp.core.formats import OPERAND_BITS
from gravcomp.facts import ACTIVATION_CLOCKS
from gravcomp.twin.network import activation, vertex_activation
from gravcomp_lab.benches.codes import fixed_network
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from machines import shipped_in
from runner import simulate

CODES = np.arange(-(2 ** (OPERAND_BITS - 1)), 2 ** (OPERAND_BITS - 1))


def gamma_and_clocks():
    """The model of the form under test, and its latency."""
    return (vertex_activation, ACTIVATION_CLOCKS - 1) if fixed_network().is_lean else (activation, ACTIVATION_CLOCKS)


@cocotb.test()
async def every_code(dut):
    gamma, clocks = gamma_and_clocks()
    await start(dut)
    got = await stream(dut, [{"in_a": pack([a], OPERAND_BITS)} for a in CODES], ["out_h"])
    np.testing.assert_array_equal(unpack(got.outputs["out_h"], OPERAND_BITS, 1)[:, 0], gamma(CODES))
    assert latencies(got) == {clocks}


@cocotb.test()
async def reset_in_mid_stream(dut):
    (gamma, _), codes = gamma_and_clocks(), np.array([1000, 2000, 3000])
    await start(dut)
    for got in await after_resets(dut, [{"in_a": int(a)} for a in codes], ["out_h"], range(1, 6), flush_clocks=8):
        np.testing.assert_array_equal(got.outputs["out_h"], gamma(codes))


@pytest.mark.slow
def test_activation_equals_model_for_every_code():
    simulate("gc_activation", "test_rtl_activation", tests="every_code")


def test_activation_forgets_what_is_under_way_at_a_reset():
    simulate("gc_activation", "test_rtl_activation", tests="reset_in_mid_stream", label="reset")


def simulate_lean(tests: str) -> None:
    weights, generated = shipped_in("lean")
    environment = {"WEIGHTS": str(weights)}
    simulate("gc_activation", "test_rtl_activation", tests=tests, label=f"lean {tests}", environment=environment,
             generated=generated)  # fmt: skip


@pytest.mark.slow
def test_vertex_form_equals_model_for_every_code():
    simulate_lean("every_code")


def test_vertex_form_forgets_what_is_under_way_at_a_reset():
    simulate_lean("reset_in_mid_stream")
