"""A network for a core that is built: its output scales are free, as long as the formats there hold them.

F = f_scale (V h + b_o) + f_offset = (s f_scale) ((V / s) h + b_o / s) + f_offset for any s > 0 of each axis. A network
that was trained again seldom has the largest weight and the offset that the ROM's formats were made for; another s
often brings both into them.
"""

from dataclasses import replace

import numpy as np

from gravcomp.core.formats import OPERAND_MAX, OUTPUT_HEADROOM, FixedNetwork
from gravcomp.network.weights import Network


def rescaled(network: Network, formats: FixedNetwork) -> Network:
    """The same network with those output scales nearest to its own that the formats of a core hold.

    Where there is no such scale the nearest that hold f_scale: ``quantise`` refuses the rest by name.
    """
    scale = np.clip(1.0, *_ends(network, formats))
    return replace(
        network,
        output_weights=network.output_weights / scale[:, None],
        output_bias=network.output_bias / scale,
        f_scale=network.f_scale * scale,
    )


def _ends(network: Network, formats: FixedNetwork) -> tuple[np.ndarray, np.ndarray]:
    """The least s (n,) that weights and offset ask for, and the largest that f_scale allows, which comes first."""
    weight_max = OPERAND_MAX * 2.0**-formats.output_weight_fraction
    ratio_max = OPERAND_MAX * 2.0**-formats.y_fraction / OUTPUT_HEADROOM - 1.0
    scale_max = OPERAND_MAX * 2.0 ** (formats.y_fraction - formats.output_scale_fraction.astype(float)) / 1000.0
    of_weights = np.abs(network.output_weights).max(axis=1) / weight_max
    of_offset = np.abs(network.f_offset / network.f_scale) / ratio_max if ratio_max > 0 else np.zeros(network.n_axes)
    most = scale_max / network.f_scale
    return np.minimum(np.maximum(of_weights, of_offset), most), most
