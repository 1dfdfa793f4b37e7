"""The lean form of the network: two stages and a multiplication per neuron less, in the FixedNetwork of the paper's.

    count -> clamp to the trained range -> count code (>> count_shift) = x -> a = W' x + b' -> h = Gamma(a)
          -> V' h + b' -> effort y in mN or mNm

- Both scalings are part of weights and biases.
- Vertex form: |Gamma(a)| = 1 - u^2, u = 1 - |a|/2, which gravcomp.twin.network.vertex_activation explains.
- Products lose the bits that no result needs before they are summed; what is lost on average is in the bias.
- V' reaches from the smallest effort to the largest in 18 bits. It is rounded column by column, the columns left fitted
  again by least squares to the float network over the workspace, in the best of some random orders. One pose in twenty
  is drawn from the whole trained range: what lies outside the workspace is fitted too, but does not lead.

The serial form is this one on a single multiplier, in turn. Its weights have fewer bits, so that two blocks of a small
part make the product, and more orders are tried as rounding loses more. The square has the place of a weight for
t = u - 1/2: u^2 = u/2 + u t, gravcomp.twin.network.serial_square. All products lose the same bits: one adder takes
them.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.formats import FixedNetwork
from gravcomp.errors import InputError
from gravcomp.network.inputs import SIN_COS, weight_columns
from gravcomp.network.weights import HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV, Network
from gravcomp.robot.machine import LEAN, ROBOT_TOML, SERIAL, Drive
from gravcomp.twin import network as bittrue

N_POSES, N_ORDERS, SEED = 20000, 60, 1
# Of a weight in the serial form: what `gravcomp formats --bits` shows to be enough; no more fits two SB_MAC16.
SERIAL_BITS, N_SERIAL_ORDERS = 16, 200
_TRAINED_RANGE_SHARE = 1 / 20
# Bits below the LSB of a, and below a mN, that products keep: their truncations add up to less than one of it.
_GUARD_HIDDEN, _GUARD_OUTPUT = 3, 4
# Beyond the trained efforts. y saturates at a power of two: more room might double what it takes for right.
_HEADROOM = 2.0**-7
_WEIGHT_FRACTIONS, _OUTPUT_FRACTIONS = (q.PREACTIVATION_FRACTION, 44), (-q.HIDDEN_FRACTION, 24)


def lean_network(
    network: Network,
    drive: Drive,
    q_m: np.ndarray,
    folder: Path | str = "weights",
    formats: FixedNetwork | None = None,
    serial_bits: int | None = None,
) -> FixedNetwork:
    """The lean form of a float network, V' fitted at positions q_m (N, n), m or rad.

    folder and formats as in gravcomp.core.formats.quantise; raises InputError as it does, and for inputs sin_cos.
    serial_bits: for the serial form instead, with weights of so many bits; it keeps no formats.
    """
    folder, is_serial = Path(folder), serial_bits is not None
    if SIN_COS in network.inputs:
        raise InputError(
            f"{folder / ROBOT_TOML}: [network] form = {SERIAL if is_serial else LEAN!r} takes positions alone, not the "
            "input sin_cos; give form = 'paper'"
        )
    if formats:
        q.check_size(network, formats, folder)
    kept = vars(formats) if formats else {}
    paper = replace(
        q.quantise(network, drive, folder),
        is_lean=True,
        is_serial=is_serial,
        weight_bits=serial_bits if is_serial else q.OPERAND_BITS,
    )
    fixed = _with_hidden(_with_places(paper, network, drive, folder, kept), network, drive, folder, kept)
    shape = round(_TRAINED_RANGE_SHARE * len(q_m)), network.n_axes
    anywhere = np.random.default_rng(SEED).integers(fixed.count_low, fixed.count_high + 1, shape)
    ends = drive.positions(fixed.count_low), drive.positions(fixed.count_high)  # beyond them the core clamps
    q_m = np.concatenate([np.clip(q_m, *ends), drive.positions(anywhere)])
    return _with_output(fixed, network, drive.counts(q_m), 1000.0 * network.forces(q_m), folder, kept)


def _with_places(paper: FixedNetwork, network: Network, drive: Drive, folder: Path, kept: Mapping) -> FixedNetwork:
    """Input of the lean form, where the binary points of both layers are, and what their products lose."""
    shift = q.shift_of_counts(paper.count_low, paper.count_high, folder / SCALING_CSV, kept.get("count_shift"))
    columns = [f"{name}, per count code" for name in weight_columns(network.inputs)]
    fraction = q.fraction_for(
        _per_code(network, drive, shift),
        folder / HIDDEN_CSV,
        columns,
        kept.get("weight_fraction"),
        _WEIGHT_FRACTIONS,
        paper.weight_bits,
    )
    columns = [f"v_{j}, mN per unit of Gamma" for j in range(1, network.n_hidden + 1)]
    output_fraction = q.fraction_for(
        1000.0 * network.f_scale[:, None] * network.output_weights,
        folder / OUTPUT_CSV,
        columns,
        kept.get("output_weight_fraction"),
        _OUTPUT_FRACTIONS,
        paper.weight_bits,
    )
    drops = fraction - q.PREACTIVATION_FRACTION - _GUARD_HIDDEN, q.HIDDEN_FRACTION + output_fraction - _GUARD_OUTPUT
    if paper.is_serial:
        drops = 2 * (min(*drops, bittrue.half_u_shift(replace(paper, output_product_drop=0))),)
    return replace(
        paper,
        count_shift=shift,
        input_scale=np.ones(network.n_axes, np.int64),
        input_scale_fraction=np.zeros(network.n_axes, np.int64),
        x_fraction=0,
        x_low=paper.count_low >> shift,
        x_high=paper.count_high >> shift,
        weight_fraction=fraction,
        hidden_product_drop=max(drops[0], 0),
        output_weight_fraction=output_fraction,
        output_product_drop=max(drops[1], 0),
    )


def _per_code(network: Network, drive: Drive, shift: np.ndarray) -> np.ndarray:
    """Weights W' (h, n), per code of x."""
    return network.hidden_weights * (network.q_scale * drive.unit_per_count * 2.0**shift)


def _with_hidden(places: FixedNetwork, network: Network, drive: Drive, folder: Path, kept: Mapping) -> FixedNetwork:
    """Hidden layer of the lean form."""
    path, shift = folder / HIDDEN_CSV, places.count_shift
    fraction, drop = places.weight_fraction, places.hidden_product_drop
    codes = np.rint(np.ldexp(_per_code(network, drive, shift), fraction)).astype(np.int64)
    # What a code lacks of its count on average, in codes, and what products lose. The middle of what a code of a stands
    # for is where the vertex form takes it: nothing is added for that.
    lacks = np.ldexp(codes, -fraction) @ ((1.0 - 2.0**-shift) / 2) + np.ldexp(
        network.n_axes / 2 if drop else 0.0, drop - fraction
    )
    bias = network.hidden_bias - network.hidden_weights @ (network.q_offset * network.q_scale) + lacks
    fixed = replace(places, hidden_weights=codes, hidden_bias=q.bias_codes(bias, fraction - drop, path))
    interval = q.partial_sum_interval(codes, fixed.hidden_bias, fixed.x_low, fixed.x_high, drop)
    bits = q.sum_bits(interval, fixed.preactivation_drop, path, kept.get("hidden_sum_bits"))
    return replace(fixed, hidden_sum_bits=bits)


def _with_output(
    hidden: FixedNetwork, network: Network, counts: np.ndarray, effort_mn: np.ndarray, folder: Path, kept: Mapping
) -> FixedNetwork:
    """Output layer of the lean form for counts (N, n) and the efforts that are wanted (N, n), mN or mNm."""
    fraction, drop = hidden.output_weight_fraction, hidden.output_product_drop
    h = bittrue.activate(bittrue.hidden_lane(bittrue.input_scaler(counts, hidden)[0], hidden), hidden)
    codes, bias = _rounded(np.ldexp(h.astype(float), -q.HIDDEN_FRACTION), effort_mn, hidden)
    # The halves of what the last mN and the products lose.
    sum_fraction = q.HIDDEN_FRACTION + fraction - drop
    bias = bias + 0.5 + np.ldexp(network.n_hidden / 2 if drop else 0.0, -sum_fraction)
    fixed = replace(
        hidden,
        output_weights=codes,
        output_bias=q.bias_codes(bias, sum_fraction, folder / OUTPUT_CSV),
        y_fraction=0,
        y_bits=_y_bits(network, folder / SCALING_CSV, kept.get("y_bits")),
        output_scale=np.ones(network.n_axes, np.int64),
        output_scale_fraction=np.zeros(network.n_axes, np.int64),
    )
    one = 2**q.HIDDEN_FRACTION
    interval = q.partial_sum_interval(codes, fixed.output_bias, -one, one - 1, drop)
    least = fixed.output_drop + fixed.y_bits - q.OPERAND_BITS
    bits = q.sum_bits(interval, least, folder / OUTPUT_CSV, kept.get("output_sum_bits"))
    if not hidden.is_serial:
        return replace(fixed, output_sum_bits=bits)
    one_sum = max(bits, hidden.hidden_sum_bits, q.bits_for(*bittrue.serial_square_interval(hidden)))
    return replace(fixed, hidden_sum_bits=one_sum, output_sum_bits=one_sum)


def _y_bits(network: Network, path: Path, kept: int | None) -> int:
    """Width in mN or mNm that holds the trained efforts of every axis, or a kept one."""
    reach = 1000.0 * network.f_scale * (1.0 + _HEADROOM)
    ends = 1000.0 * network.f_offset - reach, 1000.0 * network.f_offset + reach
    bits, most = q.bits_for(int(np.floor(ends[0].min())), int(np.ceil(ends[1].max()))), kept or q.FORCE_BITS
    if bits > most:
        raise InputError(f"{path}: efforts exceed {most} bits of mN or mNm; give a smaller scale")
    return kept or bits


def _rounded(h: np.ndarray, effort_mn: np.ndarray, fixed: FixedNetwork) -> tuple[np.ndarray, np.ndarray]:
    """Codes of V' (n, h) and bias (n,), mN, for activations h (N, h) and the efforts that are wanted (N, n)."""
    rng, n_hidden = np.random.default_rng(SEED), h.shape[1]
    columns = np.c_[h, np.ones(len(h))]
    triangle = np.linalg.qr(np.c_[columns, effort_mn], mode="r")  # least squares sees no more of the poses
    a, wanted = triangle[:, : n_hidden + 1], triangle[:, n_hidden + 1 :]
    fraction, n_orders = fixed.output_weight_fraction, N_SERIAL_ORDERS if fixed.is_serial else N_ORDERS
    largest, best = 2 ** (fixed.weight_bits - 1) - 1, []
    for y in wanted.T:
        tried = [_in_order(a, y, rng.permutation(n_hidden), fraction, largest) for _ in range(n_orders)]
        best.append(min(tried, key=lambda own: np.linalg.norm(a @ own - y)))
    best = np.array(best)
    return np.rint(np.ldexp(best[:, :-1], fraction)).astype(np.int64), best[:, -1]


def _in_order(a: np.ndarray, y: np.ndarray, order: np.ndarray, fraction: int, largest: int) -> np.ndarray:
    """Least squares of a x = y, all but the last unknown rounded one after the other, the others fitted again; none
    with a code beyond the largest.

    With the columns of a turned to a triangle in the opposite order, this is its back substitution, rounded (Babai's
    nearest plane). A column that those not yet rounded can replace gets 0.
    """
    columns = np.r_[a.shape[1] - 1, order[::-1]]
    triangle = np.linalg.qr(np.c_[a[:, columns], y], mode="r")
    r, wanted = triangle[: len(columns), :-1], triangle[: len(columns), -1]
    least = np.finfo(float).eps * len(a) * np.abs(r).max()
    x = np.zeros(len(columns))
    for i in range(len(columns) - 1, -1, -1):
        if abs(r[i, i]) > least:
            x[i] = (wanted[i] - r[i, i + 1 :] @ x[i + 1 :]) / r[i, i]
        if i > 0:
            x[i] = np.ldexp(np.clip(np.rint(np.ldexp(x[i], fraction)), -largest, largest), -fraction)
    return x[np.argsort(columns)]
