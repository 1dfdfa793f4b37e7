"""The bit-true encoder interface against the truth: the position of the encoder that drives it."""

import numpy as np
import pytest

from encoder_losses import LOSSES
from encoder_scenarios import SCENARIOS, pins
from gravcomp.twin.encoder import DecoderConfig, quad_decoder, quadrature, wrap_32

SEED = 20
CONFIGS = [
    DecoderConfig(stages, samples, phase, 120)
    for stages, samples, phase in ((2, 0, 2), (2, 1, 1), (3, 2, 3), (2, 4, 2), (4, 5, 0))
]


@pytest.mark.parametrize("config", CONFIGS, ids=str)
@pytest.mark.parametrize("name", SCENARIOS)
def test_quad_decoder_follows_the_encoder(name, config):
    print(f"seed {SEED}")
    inputs, check = SCENARIOS[name](config, np.random.default_rng(SEED))
    check(quad_decoder(pins(inputs), config))


@pytest.mark.parametrize("seed", range(SEED, SEED + 4))
@pytest.mark.parametrize("config", CONFIGS[3:], ids=str)
@pytest.mark.parametrize("name", LOSSES)
def test_quad_decoder_tells_lost_counts(name, config, seed):
    inputs, check = LOSSES[name](config, np.random.default_rng(seed))
    check(quad_decoder(pins(inputs), config))


def test_quadrature_changes_one_channel_per_count():
    a, b = quadrature(np.arange(-9, 9))
    assert np.array_equal(np.abs(np.diff(a)) + np.abs(np.diff(b)), np.ones(17))
    assert (a[9:13].tolist(), b[9:13].tolist()) == ([0, 1, 1, 0], [0, 0, 1, 1])


def test_wrap_32_is_twos_complement():
    assert [wrap_32(value) for value in (2**31 - 1, 2**31, -(2**31), -(2**31) - 1, 0)] == [
        2**31 - 1, -(2**31), -(2**31), 2**31 - 1, 0,
    ]  # fmt: skip
