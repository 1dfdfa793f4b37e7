"""The bit-true encoder interface against the truth: the position of the encoder that drives it."""

import numpy as np
import pytest

from encoder_losses import LOSSES
from encoder_scenarios import SCENARIOS, pins
from gravcomp.twin.encoder import DecoderConfig, edge_watch, quad_decoder, quadrature, wrap_32

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


@pytest.mark.parametrize("clocks", [DecoderConfig.dither_clocks, 100, 1000, 25_000])
def test_ten_million_clocks_of_dither_about_one_edge_are_no_fault(clocks):
    """One axis trembles after a move, at a steady rate or at random, the others move all along."""
    n_clocks, rng, config = 10**7, np.random.default_rng(SEED), DecoderConfig()
    print(f"seed {SEED}")
    most = n_clocks // clocks
    spacings = {
        "steady": np.full(most, clocks),
        "random": rng.integers(clocks, 4 * clocks, most),
        "moving": np.full(n_clocks // 50, 50),
        "turning": rng.integers(8, 60, n_clocks // 60),
    }
    step_up = {
        "steady": np.arange(most) % 2,
        "random": np.arange(most) % 2,
        "moving": np.ones(n_clocks // 50, np.int8),
        "turning": np.arange(n_clocks // 60) // 7 % 2,
    }
    for name, spacing in spacings.items():
        when = 2 * config.reversal_clocks + np.cumsum(spacing)
        when = when[when < n_clocks]
        quiet, valid, up = np.zeros((3, n_clocks), np.int8)
        valid[when], up[when] = 1, step_up[name][: len(when)]
        valid[:8], up[:8] = 1, step_up[name][0] ^ 1  # a fast move, with time enough to stop
        broken = edge_watch(quiet, valid, up, quiet, config.reversal_clocks, config.dither_clocks)
        assert valid.sum() > n_clocks // (4 * clocks), name
        assert not broken.any(), name


def test_dither_faster_than_it_may_be_for_ever_is_a_fault():
    config, n_clocks = DecoderConfig(), 10**6
    quiet, valid = np.zeros((2, n_clocks), np.int8)
    valid[:: config.dither_clocks - 1] = 1
    up = np.cumsum(valid) % 2
    assert edge_watch(quiet, valid, up, quiet, config.reversal_clocks, config.dither_clocks).any()


def test_quadrature_changes_one_channel_per_count():
    a, b = quadrature(np.arange(-9, 9))
    assert np.array_equal(np.abs(np.diff(a)) + np.abs(np.diff(b)), np.ones(17))
    assert (a[9:13].tolist(), b[9:13].tolist()) == ([0, 1, 1, 0], [0, 0, 1, 1])


def test_wrap_32_is_twos_complement():
    assert [wrap_32(value) for value in (2**31 - 1, 2**31, -(2**31), -(2**31) - 1, 0)] == [
        2**31 - 1, -(2**31), -(2**31), 2**31 - 1, 0,
    ]  # fmt: skip
