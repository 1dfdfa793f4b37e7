"""What a network sees of the axes: the position of each, or the sine and cosine of it."""

from collections.abc import Sequence

import numpy as np

POSITION, SIN_COS = "position", "sin_cos"
INPUTS = (POSITION, SIN_COS)


def inputs_of(q: np.ndarray, q_offset: np.ndarray, q_scale: np.ndarray, kinds: Sequence[str]) -> np.ndarray:
    """Inputs x (..., p) at positions q (..., n): (q - q_offset) q_scale, or sin and cos of q - q_offset, axis by axis.

    kinds (n,): which of INPUTS each axis gives.
    """
    if SIN_COS not in kinds:
        return (q - q_offset) * q_scale
    columns = []
    for axis, kind in enumerate(kinds):
        away = q[..., axis] - q_offset[axis]
        columns += [np.sin(away), np.cos(away)] if kind == SIN_COS else [away * q_scale[axis]]
    return np.stack(columns, axis=-1)


def axis_of_input(kinds: Sequence[str]) -> np.ndarray:
    """The axis (p,) that each input comes from."""
    return np.repeat(np.arange(len(kinds)), [2 if kind == SIN_COS else 1 for kind in kinds])


def weight_columns(kinds: Sequence[str]) -> list[str]:
    """Names of the inputs' columns in hidden.csv."""
    names = ((f"w_sin{i}", f"w_cos{i}") if kind == SIN_COS else (f"w_q{i}",) for i, kind in enumerate(kinds, start=1))
    return [name for pair in names for name in pair]
