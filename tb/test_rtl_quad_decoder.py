"""gc_quad_decoder equals its bit-true model on every clock, and shows what the encoder did."""

import os

import cocotb
import numpy as np
import pytest

from encoder_losses import LOSSES
from encoder_scenarios import SCENARIOS, pins
from gravcomp.twin.encoder import DecoderConfig, quad_decoder
from playback import assert_equal, play
from runner import simulate

OUTPUTS = (
    "count_valid", "count", "direction", "speed_valid", "speed_zero", "speed_period",
    "sts_referenced", "sts_illegal", "sts_glitch",
)  # fmt: skip


def config_of_build() -> DecoderConfig:
    return DecoderConfig(
        int(os.environ["SYNC_STAGES_G"]),
        int(os.environ["FILTER_SAMPLES_G"]),
        int(os.environ["INDEX_PHASE_G"]),
        int(os.environ["SPEED_TIMEOUT_G"]),
    )


@cocotb.test()
async def starts_without_reset(dut):
    """Power-up values alone make a working decoder: pins that rest high give no count."""
    config = config_of_build()
    inputs, _ = SCENARIOS["latency"](config, np.random.default_rng(1))
    recorded = await play(dut, pins(inputs), OUTPUTS, reset=False)
    assert_equal(recorded, quad_decoder(pins(inputs), config))


@cocotb.test()
@cocotb.parametrize(name=list(SCENARIOS), seed=[21, 22])
async def follows_the_encoder(dut, name, seed):
    config = config_of_build()
    cocotb.log.info("seed %d", seed)
    inputs, check = SCENARIOS[name](config, np.random.default_rng(seed))
    recorded = await play(dut, pins(inputs), OUTPUTS)
    assert_equal(recorded, quad_decoder(pins(inputs), config))
    check(recorded)


@cocotb.test()
@cocotb.parametrize(name=list(LOSSES), seed=[23])
async def tells_lost_counts(dut, name, seed):
    config = config_of_build()
    cocotb.log.info("seed %d", seed)
    inputs, check = LOSSES[name](config, np.random.default_rng(seed))
    recorded = await play(dut, pins(inputs), OUTPUTS)
    assert_equal(recorded, quad_decoder(pins(inputs), config))
    check(recorded)


@pytest.mark.parametrize(
    ("stages", "samples", "phase"),
    [(2, 0, 2), (2, 1, 1), (3, 2, 3), (2, 4, 2), (4, 5, 0)],
    ids=lambda value: str(value),
)
def test_quad_decoder_equals_bit_true(stages, samples, phase):
    generics = dict(sync_stages_g=stages, filter_samples_g=samples, index_phase_g=phase, speed_timeout_g=120)
    tests = None if samples >= 4 else r"\.(starts|follows)"  # what is lost without a filter is another matter
    simulate("gc_quad_decoder", "test_rtl_quad_decoder", generics=generics, tests=tests)


@pytest.mark.parametrize(
    ("generics", "message"),
    [
        ({"sync_stages_g": 1}, "gc_synchronizer: need stages_g >= 2, got 1"),
        ({"index_phase_g": 4}, "gc_quad_decoder: need index_phase_g in 0 .. 3, got 4"),
    ],
    ids=str,
)
def test_quad_decoder_refuses_generics(generics, message):
    with pytest.raises(AssertionError, match=message):
        simulate("gc_quad_decoder", "test_rtl_quad_decoder", generics=generics)
