"""The noise that no model made: right within a few per cent beside whatever the machine does, of any kind of log."""

import numpy as np
import pytest

from gravcomp.diagnosis.samples.noise import model_free
from gravcomp.logs.measurement import Measurement

SIGMA = 0.2


def log(t_s, q, v, residual) -> tuple[Measurement, np.ndarray]:
    data = Measurement("log", t_s, q, v, residual, np.zeros_like(q), "N", ("m",) * q.shape[1])
    return data, residual


def motion(n=1200, seed=1, step_s=0.1):
    """Three axes in slow motion; the poses of a run are hardly passed again."""
    t = step_s * np.arange(n)
    w = np.array([0.21, 0.13, 0.154])
    q = 0.2 * np.sin(w * t[:, None] + seed)
    return t, q, 0.2 * w * np.cos(w * t[:, None] + seed)


def holds(n=400, seed=2):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-0.2, 0.2, (n, 3))
    return np.arange(float(n)), q, rng.choice([-0.01, 0.01], q.shape)


def white(shape, seed=3):
    return SIGMA * np.random.default_rng(seed).standard_normal(shape)


STRUCTURE = {
    "nothing": lambda t, q, v: 0.0 * q,
    "another axis' speed": lambda t, q, v: 30.0 * np.roll(v, 1, axis=1),
    "a soft stop": lambda t, q, v: 20.0 * np.maximum(q - 0.1, 0.0),
    "friction": lambda t, q, v: 0.6 * np.sign(v),
    "a slow drift": lambda t, q, v: 0.0 * q + np.sin(t / 30.0)[:, None],
}


@pytest.mark.parametrize("structure", STRUCTURE)
def test_noise_of_a_motion_whatever_else_is_left(structure):
    t, q, v = motion()
    data, left = log(t, q, v, STRUCTURE[structure](t, q, v) + white(q.shape))
    noise = model_free(data, left, np.ones(q.shape, bool))
    assert noise.is_sure
    assert noise.sigma == pytest.approx([SIGMA] * 3, rel=0.12)


@pytest.mark.parametrize("structure", ["nothing", "another axis' speed", "a soft stop", "a slow drift"])
def test_noise_of_scattered_holds_is_the_best_there_is(structure):
    """Neighbours are far: drawn to distance zero what differs between them falls away, and the word is not sure."""
    t, q, v = holds()
    data, left = log(t, q, v, STRUCTURE[structure](t, q, v) + white(q.shape))
    noise = model_free(data, left, np.ones(q.shape, bool))
    assert not noise.is_sure
    assert 0.8 * SIGMA < noise.rms < 1.3 * SIGMA


def test_noise_that_is_correlated_over_a_few_samples_is_noise():
    """Neighbours of one sample see 0.57 of a first-order noise of 0.6; those six off see 0.98 of it."""
    t, q, v = motion(2400, step_s=0.04)
    fresh, left = white(q.shape), np.zeros(q.shape)
    for k in range(1, len(q)):
        left[k] = 0.6 * left[k - 1] + 0.8 * fresh[k]
    data, left = log(t, q, v, left)
    assert model_free(data, left, np.ones(q.shape, bool)).rms == pytest.approx(SIGMA, rel=0.12)


def test_repeats_of_a_pose_are_the_noise():
    _, q, v = holds(60)
    q, v = np.tile(q, (4, 1)), np.tile(v, (4, 1))
    data, left = log(np.arange(240.0), q, v, 50.0 * q**2 + white(q.shape))
    noise = model_free(data, left, np.ones(q.shape, bool))
    assert noise.source == "repeats of a pose"
    assert noise.rms == pytest.approx(SIGMA, rel=0.12)


def test_too_few_samples_say_so():
    t, q, v = holds(12)
    data, left = log(t, q, v, white(q.shape))
    noise = model_free(data, left, np.ones(q.shape, bool))
    assert not noise.is_sure
    assert "fewer than" in noise.source


@pytest.mark.parametrize("seed", [11, 21, 31])
def test_line_through_noise_alone_draws_nothing_lower(seed):
    """Few passes of one axis: where differences do not surely grow with the distance their mean is the noise."""
    rng = np.random.default_rng(seed)
    t = 0.05 * np.arange(900)
    w, (a, b) = rng.uniform(0.5, 1.1), rng.uniform(0.0, 6.28, 2)
    q = 1.2 * (np.sin(w * t + a) + 0.4 * np.sin(0.618 * w * t + b))[:, None]
    data, left = log(t, q, np.gradient(q, t, axis=0), SIGMA * rng.standard_normal(q.shape))
    assert model_free(data, left, np.ones(q.shape, bool)).sigma == pytest.approx([SIGMA], rel=0.1)
