"""Errors of forces, as the paper's Table 2 states them."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ForceError:
    """mean_n: mean of |E|; rms_n: over poses and axes; max_n: largest component; percent: 100 |E| / |F| per pose."""

    mean_n: float
    rms_n: float
    max_n: float
    average_percent: float
    max_percent: float


def force_error(force_n: np.ndarray, reference_n: np.ndarray) -> ForceError:
    """Error statistics of forces (k, n) against a reference (k, n), N; |.| is the norm over the axes of a pose."""
    error = force_n - reference_n
    norm = np.linalg.norm(error, axis=1)
    percent = 100.0 * norm / np.linalg.norm(reference_n, axis=1)
    return ForceError(
        mean_n=float(norm.mean()),
        rms_n=float(np.sqrt((error**2).mean())),
        max_n=float(np.abs(error).max()),
        average_percent=float(percent.mean()),
        max_percent=float(percent.max()),
    )
