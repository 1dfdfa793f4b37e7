"""gc_glitch_filter equals its bit-true model, and passes exactly the pulses that are long enough."""

import os

import cocotb
import numpy as np
import pytest

from gravcomp.twin.encoder import glitch_filter
from playback import assert_equal, play
from runner import simulate

OUTPUTS = ("out_valid", "out_level", "out_sample", "out_dropped")


@cocotb.test()
async def equals_bit_true_on_noise(dut):
    rng = np.random.default_rng(4)
    cocotb.log.info("seed 4")
    samples = int(os.environ["SAMPLES_G"])
    level = np.repeat(np.arange(600) % 2, rng.integers(1, 2 * samples + 3, 600))
    inputs = {"rst": rng.random(len(level)) < 0.01, "in_valid": rng.random(len(level)) < 0.98, "in_level": level}
    inputs = {name: values.astype(np.int64) for name, values in inputs.items()}
    recorded = await play(dut, inputs, OUTPUTS, reset=False)
    expected = glitch_filter(inputs["rst"], inputs["in_valid"], inputs["in_level"], samples)
    assert_equal(recorded, expected)


@cocotb.test()
@cocotb.parametrize(rest=[0, 1])
async def passes_pulses_of_its_length(dut, rest):
    """At the limit and one below, from both levels: late by the stated latency, full length; dropped is told once."""
    samples = int(os.environ["SAMPLES_G"])
    for length in range(max(samples - 1, 1), samples + 2):
        level = np.full(6 * samples + 20, rest)
        begin = 2 * samples + 4
        level[begin : begin + length] ^= 1
        quiet = np.zeros_like(level)
        recorded = await play(dut, {"in_valid": quiet + 1, "in_level": level}, OUTPUTS)
        known = np.flatnonzero(recorded["out_valid"])
        assert known[0] == samples
        assert known[-1] - known[0] + 1 == len(known) == len(level) - samples
        pulse = np.flatnonzero(recorded["out_level"][known] != rest) + samples
        passed = range(begin + samples, begin + samples + length) if length >= samples else ()
        assert pulse.tolist() == list(passed)
        assert recorded["out_dropped"].sum() == (length < samples)


@pytest.mark.parametrize("samples", [0, 1, 2, 5])
def test_glitch_filter_equals_bit_true(samples):
    simulate("gc_glitch_filter", "test_rtl_glitch_filter", generics={"samples_g": samples})
