"""The piecewise-quadratic activation Gamma and the tanh that it stands in for.

Source: Kwan (1992), as used by the paper (equation 3), with L = 2, beta = 1, theta = 1/4.
"""

import numpy as np

LIMIT = 2.0  # L
BETA = 1.0
THETA = 0.25


def gamma(x: np.ndarray) -> np.ndarray:
    """Gamma(x) = x (beta - theta |x|) for |x| <= L, sign(x) beyond. Any shape, no unit."""
    clipped = np.clip(x, -LIMIT, LIMIT)
    return clipped * (BETA - THETA * np.abs(clipped))


def gamma_slope(x: np.ndarray) -> np.ndarray:
    """dGamma/dx = beta - 2 theta |x| for |x| <= L, zero beyond."""
    return BETA - 2.0 * THETA * np.minimum(np.abs(x), LIMIT)
