"""gc_input_stage: positions, sines and cosines side by side, bit-true, however each is shared."""

import os
from unittest.mock import patch

import cocotb
import numpy as np
import pytest

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import COUNT_BITS, OPERAND_BITS
from gravcomp.twin.network import input_stage
from gravcomp_lab.benches.core import draw_counts
from gravcomp_lab.benches.stream import latencies, start, stream
from runner import simulate
from test_rtl_turn_stage import turn_latency, turning_rom


@cocotb.test()
async def counts_in_and_out_of_range(dut):
    fixed, rng = fixed_network(), np.random.default_rng(33)
    is_serial, is_shared = (os.environ[name] == "true" for name in ("SERIAL_G", "SHARED_G"))
    counts = np.concatenate([draw_counts(200, rng), corners_and_random(COUNT_BITS, (100, fixed.n_axes), rng)])
    inputs = [{"in_count": pack(row, COUNT_BITS)} for row in counts]
    spacing = fixed.n_axes if is_serial or is_shared else 1
    await start(dut)
    got = await stream(dut, inputs, ["out_x", "out_clamped"], spacing=spacing, gap_probability=0.2, rng=rng)
    x, is_clamped = input_stage(counts, fixed)
    np.testing.assert_array_equal(unpack(got.outputs["out_x"], OPERAND_BITS, fixed.n_inputs), x)
    np.testing.assert_array_equal(unpack(got.outputs["out_clamped"], 1, fixed.n_axes) != 0, is_clamped)
    assert latencies(got) == {turn_latency(fixed, is_shared)}
    assert int(dut.out_x.value) == got.outputs["out_x"][-1], "the result did not hold"


@pytest.mark.parametrize(("serial", "shared"), [("false", "false"), ("true", "true")])
def test_input_stage_equals_model(serial, shared, tmp_path):
    environment, generated = turning_rom(tmp_path)
    with patch.dict(os.environ, environment):
        generics = {"serial_g": serial, "shared_g": shared}
        simulate("gc_input_stage", "test_rtl_input_stage", generics=generics, generated=generated)
