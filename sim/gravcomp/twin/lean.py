"""The lean form of the network, in integers: a study for a smaller core; no VHDL of it is there yet.

    count -> clamp -> code -> a = W' code + b' -> u -> g = u^2 - 1 = -|Gamma(a)| -> force in mN = V' Gamma(a) + b'

- Both scalings are in weights and biases: code is that of the count, the output sum is in mN.
- Vertex form: a (1 - |a|/4) = sign(a) (1 - u^2), u = 1 - |a|/2. The code of u is the lower bits of a, inverted where
  a >= 0: within half an LSB of a, the same on both sides; saturation is u = 0; the sign of a goes
  into V'. Per neuron one multiplication less than in gc_activation: 140 in all for 3-20-3.
- Products lose the bits that no result needs before they are summed; what is lost on average is in the bias. The widths
  are those of partial_sum_interval, for all counts.
- V' has to reach from the smallest force to the largest in 18 bits. It is rounded column by column, the columns left
  fitted again by least squares to the float network, in the best of some random orders.
"""

import math
from dataclasses import dataclass

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.formats import FixedNetwork, bits_for, partial_sum_interval
from gravcomp.errors import InputError
from gravcomp.network.inputs import SIN_COS
from gravcomp.network.weights import Network
from gravcomp.robot.machine import Drive
from gravcomp.twin.network import saturate

# Bits below the LSB of a, and below a mN, that products keep: their truncations add up to less than one of it.
_GUARD_HIDDEN, _GUARD_OUTPUT = 5, 6
_LIMIT = 2 ** (q.OPERAND_BITS - 1)


@dataclass(frozen=True)
class LeanNetwork:
    """Integers of the lean form; n axes, h neurons. Fractions are those of the weights, sums have less: shift bits of
    each product are dropped first. output_weights are per mN and may have a negative fraction."""

    count_low: np.ndarray
    count_high: np.ndarray
    count_shift: np.ndarray
    hidden_weights: np.ndarray
    hidden_bias: np.ndarray
    hidden_fraction: int
    output_weights: np.ndarray
    output_bias: np.ndarray
    output_fraction: int

    @property
    def hidden_shift(self) -> int:
        return max(self.hidden_fraction - q.PREACTIVATION_FRACTION - _GUARD_HIDDEN, 0)

    @property
    def output_shift(self) -> int:
        return max(q.HIDDEN_FRACTION + self.output_fraction - _GUARD_OUTPUT, 0)

    @property
    def sum_bits(self) -> tuple[int, int]:
        """Widths in which no partial sum of a or of the force can overflow, for any count."""
        ends = self.count_low >> self.count_shift, self.count_high >> self.count_shift
        hidden = partial_sum_interval(self.hidden_weights, self.hidden_bias << self.hidden_shift, *ends)
        one = 2**q.HIDDEN_FRACTION
        output = partial_sum_interval(self.output_weights, self.output_bias << self.output_shift, -one, one)
        # Each product that is cut takes at most one from its sum.
        return (
            bits_for((hidden[0] >> self.hidden_shift) - self.hidden_weights.shape[1], hidden[1] >> self.hidden_shift),
            bits_for((output[0] >> self.output_shift) - self.output_weights.shape[1], output[1] >> self.output_shift),
        )


def signed_gamma(count: np.ndarray, lean: LeanNetwork) -> np.ndarray:
    """Codes of Gamma(a), (..., h), HIDDEN_FRACTION bits, of counts (..., n)."""
    code = np.clip(count, lean.count_low, lean.count_high) >> lean.count_shift
    total = lean.hidden_bias + (code[..., None, :] * lean.hidden_weights >> lean.hidden_shift).sum(axis=-1)
    a, _ = saturate(total >> lean.hidden_fraction - lean.hidden_shift - q.PREACTIVATION_FRACTION, q.OPERAND_BITS)
    u = np.where(a < 0, a + _LIMIT, _LIMIT - 1 - a)
    g = (u * u >> q.OPERAND_BITS - 1) - _LIMIT
    return np.where(a < 0, g, -g)


def core(count: np.ndarray, lean: LeanNetwork) -> np.ndarray:
    """Forces in mN (..., n), saturated to their format, of counts (..., n)."""
    h = signed_gamma(np.asarray(count, dtype=np.int64), lean)
    total = lean.output_bias + (h[..., None, :] * lean.output_weights >> lean.output_shift).sum(axis=-1)
    return saturate(total >> q.HIDDEN_FRACTION + lean.output_fraction - lean.output_shift, q.FORCE_BITS)[0]


def lean_network(
    network: Network, fixed: FixedNetwork, drive: Drive, q_m: np.ndarray, n_orders: int, seed: int
) -> LeanNetwork:
    """The lean form of a network whose counts are clamped as those of fixed.

    V' is fitted at positions q_m (N, n), m or rad, in n_orders random orders per axis, of which the one with the
    smallest error, RMS, is taken. Raises InputError for inputs sin_cos.
    """
    if SIN_COS in network.inputs:
        raise InputError("the lean form takes positions alone; give input = position")
    per_code = network.q_scale * drive.unit_per_count * 2.0**fixed.count_shift
    weights = network.hidden_weights * per_code
    fraction = _fraction(weights)
    codes = np.rint(np.ldexp(weights, fraction)).astype(np.int64)
    shift = max(fraction - q.PREACTIVATION_FRACTION - _GUARD_HIDDEN, 0)
    dropped = (1.0 - 2.0**-fixed.count_shift) / 2  # of a code, on average
    bias = network.hidden_bias - network.hidden_weights @ (network.q_offset * network.q_scale)
    bias = bias + np.ldexp(codes, -fraction) @ dropped
    bias = np.ldexp(bias, fraction - shift) + (network.n_axes / 2 if shift else 0.0)
    lean = LeanNetwork(
        fixed.count_low, fixed.count_high, fixed.count_shift,
        codes, np.rint(bias).astype(np.int64), fraction,
        np.zeros((network.n_axes, network.n_hidden), np.int64), np.zeros(network.n_axes, np.int64),
        _fraction(1000.0 * network.f_scale[:, None] * network.output_weights),
    )  # fmt: skip
    output = _rounded(signed_gamma(drive.counts(q_m), lean), 1000.0 * network.forces(q_m), lean, n_orders, seed)
    return LeanNetwork(**(vars(lean) | output))


def _fraction(values: np.ndarray) -> int:
    """Most fraction bits with which an operand holds all values; negative where their LSB is above one."""
    largest = float(np.abs(values).max())
    fraction = q.OPERAND_BITS - 1 - math.ceil(math.log2(largest))
    return fraction - (round(math.ldexp(largest, fraction)) >= _LIMIT)


def _rounded(h: np.ndarray, force_mn: np.ndarray, lean: LeanNetwork, n_orders: int, seed: int) -> dict:
    """output_weights and output_bias for codes h (N, h) and the forces that are wanted (N, n)."""
    rng, n_hidden = np.random.default_rng(seed), h.shape[1]
    columns = np.c_[np.ldexp(h.astype(float), -q.HIDDEN_FRACTION), np.ones(len(h))]
    triangle = np.linalg.qr(np.c_[columns, force_mn], mode="r")  # least squares sees no more of the poses
    weights, bias = [], []
    for axis in range(force_mn.shape[1]):
        a, y = triangle[:, : n_hidden + 1], triangle[:, n_hidden + 1 + axis]
        tried = [_in_order(a, y, rng.permutation(n_hidden), lean.output_fraction) for _ in range(n_orders)]
        best = min(tried, key=lambda own: np.linalg.norm(columns @ own - force_mn[:, axis]))
        weights.append(np.rint(np.ldexp(best[:-1], lean.output_fraction)))
        # The halves of what the products lose, and of the last mN.
        halves = np.ldexp(0.5, q.HIDDEN_FRACTION + lean.output_fraction - lean.output_shift)
        of_products = n_hidden / 2 if lean.output_shift else 0.0
        bias.append(np.rint(2.0 * halves * best[-1] + halves + of_products))
    return {"output_weights": np.array(weights, dtype=np.int64), "output_bias": np.array(bias, dtype=np.int64)}


def _in_order(a: np.ndarray, y: np.ndarray, order: np.ndarray, fraction: int) -> np.ndarray:
    """Least squares of a x = y, all but the last unknown rounded one after the other, the others fitted again."""
    x, free = np.linalg.lstsq(a, y, rcond=None)[0], list(range(a.shape[1]))
    for j in order:
        x[j] = np.clip(np.rint(np.ldexp(x[j], fraction)), -_LIMIT, _LIMIT - 1) * 2.0**-fraction
        y = y - a[:, j] * x[j]
        free.remove(j)
        x[free] = np.linalg.lstsq(a[:, free], y, rcond=None)[0]
    return x
