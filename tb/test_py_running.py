"""States for all rows at once are those of a loop over the rows."""

import numpy as np
import pytest

from gravcomp.diagnosis.running import after_clips, after_lines

SEED = 4


@pytest.mark.parametrize("n", [1, 2, 3, 7, 64, 1001])
def test_clips_are_those_of_a_loop(n):
    rng = np.random.default_rng(SEED)
    low = rng.uniform(-1.0, 0.5, n)
    high = low + rng.choice([0.0, 0.3, 2.0], n)  # some leave no choice
    shift, state, wanted = 0.4 * rng.standard_normal(n), 0.2, []
    for own in zip(shift, low, high, strict=True):
        state = min(max(state + own[0], own[1]), own[2])
        wanted.append(state)
    np.testing.assert_allclose(after_clips(0.2, shift, low, high), wanted, atol=1e-13)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 64, 1001])
def test_lines_are_those_of_a_loop(n):
    rng = np.random.default_rng(SEED)
    gain, offset = rng.choice([0.0, 1.0, *rng.uniform(0, 1, 3)], n), rng.standard_normal(n)
    state, wanted = 0.2, []
    for own in zip(gain, offset, strict=True):
        state = own[0] * state + own[1]
        wanted.append(state)
    np.testing.assert_allclose(after_lines(0.2, gain, offset), wanted, rtol=1e-12, atol=1e-12)
