"""Test vectors of gc_core, for simulators without Python."""

import numpy as np

from gravcomp.core.formats import COUNT_BITS, FixedNetwork
from gravcomp.twin.network import core


def random_vectors(fixed: FixedNetwork, number: int, seed: int) -> np.ndarray:
    """number rows (number, 2n): encoder counts of n axes, then the forces in mN that gc_core answers with.

    A row lies in the trained range or, as often, anywhere in 32 bits; of the latter every fourth count is an extreme.
    """
    rng = np.random.default_rng(seed)
    shape = (number, fixed.n_axes)
    high = 2 ** (COUNT_BITS - 1) - 1
    low = -high  # an integer of VHDL need not hold -2^31
    inside = rng.integers(fixed.count_low, fixed.count_high, shape, endpoint=True)
    anywhere = rng.integers(low, high, shape, endpoint=True)
    extremes = rng.choice([low, -1, 0, high], shape)
    anywhere = np.where(rng.random(shape) < 0.25, extremes, anywhere)
    count = np.where(rng.random((number, 1)) < 0.5, inside, anywhere)
    return np.hstack([count, core(count, fixed).force_mn])
