"""gc_scale: exact products with n multipliers and with one; they hold until the next result."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.triggers import FallingEdge

from codes import corners_and_random, pack, unpack
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from runner import BENCHES, simulate


def products(values: np.ndarray) -> np.ndarray:
    return values * 1001 * np.arange(1, values.shape[-1] + 1)


@cocotb.test()
async def products_are_exact(dut):
    n, is_serial = int(os.environ["VALUES_G"]), os.environ["SERIAL_G"] == "true"
    rng = np.random.default_rng(8)
    values = corners_and_random(18, (200, n), rng)
    inputs = [{"in_values": pack(row, 18)} for row in values]
    await start(dut)
    spacing = n if is_serial else 1
    got = await stream(dut, inputs, ["out_products"], spacing=spacing, gap_probability=0.3, rng=rng, holds=True)
    np.testing.assert_array_equal(unpack(got.outputs["out_products"], 36, n), products(values))
    assert latencies(got) == {n + 2 if is_serial and n > 1 else 2}


@cocotb.test()
async def reset_in_mid_stream(dut):
    n, is_serial = int(os.environ["VALUES_G"]), os.environ["SERIAL_G"] == "true"
    values = np.arange(1, 3 * n + 1).reshape(3, n)
    inputs = [{"in_values": pack(row, 18)} for row in values]
    options = {"spacing": n if is_serial else 1, "holds": True, "flush_clocks": 16}
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_products"], range(1, 2 * n + 4), **options):
        np.testing.assert_array_equal(unpack(got.outputs["out_products"], 36, n), products(values))


@cocotb.test()
async def products_hold(dut):
    n = int(os.environ["VALUES_G"])
    values = np.arange(1, n + 1)[None, :]
    await start(dut)
    await stream(dut, [{"in_values": pack(values[0], 18)}], ["out_products"], holds=True)
    for _ in range(10):
        await FallingEdge(dut.clk)
        np.testing.assert_array_equal(unpack([int(dut.out_products.value)], 36, n), products(values))


@pytest.mark.parametrize(("n_values", "serial"), [(3, "false"), (3, "true"), (2, "true"), (5, "true"), (1, "true")])
def test_scale_equals_exact_products(n_values, serial):
    generics = {"values_g": n_values, "serial_g": serial}
    simulate("gc_scale_bench", "test_rtl_scale", generics=generics, extra_sources=(BENCHES / "gc_scale_bench.vhd",))
