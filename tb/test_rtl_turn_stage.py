"""gc_turn_stage: sines and cosines of the axes that turn, each with its own way or one in turn, bit-true."""

import os
from pathlib import Path
from unittest.mock import patch

import cocotb
import numpy as np
import pytest

from arm import arm_toml
from axes import random_network
from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import COUNT_BITS, OPERAND_BITS
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.network.inputs import POSITION, SIN_COS
from gravcomp.twin.network import turn_stage
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from machines import machine_folder
from runner import simulate

INPUTS = (SIN_COS, POSITION, SIN_COS, SIN_COS)


def turn_latency(fixed, is_shared: bool) -> int:
    """gc_phase, gc_sin_cos, the register that holds; one more for each axis that waits its turn."""
    return 6 + 7 + 1 + (int(fixed.is_turning.sum()) if is_shared else 0)


def expected_turns(counts, fixed) -> np.ndarray:
    return turn_stage(counts, fixed)[:, fixed.is_turning, :].reshape(len(counts), -1)


@cocotb.test()
async def corners_and_random_counts(dut):
    fixed, rng, is_shared = fixed_network(), np.random.default_rng(32), os.environ["SHARED_G"] == "true"
    n_turns = int(fixed.is_turning.sum())
    counts = corners_and_random(COUNT_BITS, (200, fixed.n_axes), rng)
    inputs = [{"in_count": pack(row, COUNT_BITS)} for row in counts]
    spacing = n_turns if is_shared else 1
    await start(dut)
    got = await stream(dut, inputs, ["out_x"], spacing=spacing, gap_probability=0.2, rng=rng)
    x = unpack(got.outputs["out_x"], OPERAND_BITS, 2 * n_turns)
    np.testing.assert_array_equal(x, expected_turns(counts, fixed))
    assert latencies(got) == {turn_latency(fixed, is_shared)}
    assert int(dut.out_x.value) == got.outputs["out_x"][-1], "the result did not hold"


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed, is_shared = fixed_network(), os.environ["SHARED_G"] == "true"
    n_turns = int(fixed.is_turning.sum())
    counts = 1000 * np.arange(1, 3 * fixed.n_axes + 1).reshape(3, -1)
    inputs = [{"in_count": pack(row, COUNT_BITS)} for row in counts]
    options = {"spacing": n_turns if is_shared else 1, "flush_clocks": 40}
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_x"], range(1, turn_latency(fixed, is_shared) + 2), **options):
        x = unpack(got.outputs["out_x"], OPERAND_BITS, 2 * n_turns)
        np.testing.assert_array_equal(x, expected_turns(counts, fixed))


def turning_rom(folder: Path) -> tuple[dict[str, str], Path]:
    """The environment and packages of an arm that turns in three of four axes, 12345 counts per turn."""
    weights, generated = folder / "weights", folder / "generated"
    machine_folder(weights, random_network(INPUTS, 5), arm_toml(len(INPUTS), "12345", INPUTS))
    write_rom(weights, generated)
    return {"WEIGHTS": str(weights)}, generated


@pytest.mark.parametrize("shared", ["false", "true"])
def test_turn_stage_equals_model(shared, tmp_path):
    environment, generated = turning_rom(tmp_path)
    with patch.dict(os.environ, environment):
        simulate("gc_turn_stage", "test_rtl_turn_stage", generics={"shared_g": shared}, generated=generated)
