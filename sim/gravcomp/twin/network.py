"""The hardware in NumPy, equal to it bit for bit: one function per entity of rtl/.

All values are integer codes (int64); their formats are those of FixedNetwork. A right shift is the truncation of
``gc_fixed_pkg`` (towards minus infinity).
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.formats import FixedNetwork
from gravcomp.twin.sin_cos import phase, sin_cos

_U_BITS = q.OPERAND_BITS - 1  # of u, which has no sign, in the vertex form of Gamma


@dataclass(frozen=True)
class CoreOutput:
    """What gc_core returns, (..., n) each: forces, mN; count outside the trained range; output sum saturated."""

    force_mn: np.ndarray
    clamped: np.ndarray
    saturated: np.ndarray


def saturate(value: np.ndarray, bits: int) -> tuple[np.ndarray, np.ndarray]:
    """Clip to the range of a signed number of that width; returns the value and whether it was clipped."""
    limited = np.clip(value, -(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return limited, limited != value


def input_stage(count: np.ndarray, fixed: FixedNetwork) -> tuple[np.ndarray, np.ndarray]:
    """gc_input_stage: counts (..., n) to codes of x (..., p), and whether each count was clamped."""
    x, is_clamped = input_scaler(count, fixed)
    if not fixed.is_turning.any():
        return x, is_clamped
    turns = turn_stage(count, fixed)
    codes = [turns[..., k, :] if fixed.is_turning[k] else x[..., k : k + 1] for k in range(fixed.n_axes)]
    return np.concatenate(codes, axis=-1), is_clamped & ~fixed.is_turning


def input_scaler(count: np.ndarray, fixed: FixedNetwork) -> tuple[np.ndarray, np.ndarray]:
    """gc_input_scaler: counts (..., n) to codes of the positions (..., n), and whether each count was clamped.

    It leaves out axes that turn; what stands here for them is of no use.
    """
    limited = np.clip(count, fixed.count_low, fixed.count_high)
    return (limited >> fixed.count_shift) * fixed.input_scale >> fixed.input_scale_fraction, limited != count


def turn_stage(count: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """gc_turn_stage: counts (..., n) to codes of sine and cosine (..., n, 2), of use for axes that turn alone."""
    both = sin_cos(phase(count, fixed.coarse_step, fixed.fine_step))
    return np.stack(both, axis=-1) >> q.SIN_COS_FRACTION - fixed.x_fraction


def hidden_lane(x: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """gc_hidden_lane: codes of x (..., p) to those of the pre-activations (..., h), saturated to [-2, 2)."""
    total = _sums(x, fixed.hidden_weights, fixed.hidden_product_drop) + fixed.hidden_bias
    return saturate(total >> fixed.preactivation_drop, q.OPERAND_BITS)[0]


def _sums(signal: np.ndarray, weights: np.ndarray, drop: int) -> np.ndarray:
    """Sums (..., m) of products of weights (m, k) and a signal (..., k), each less drop bits."""
    if not drop:
        return signal @ weights.T
    return (signal[..., None, :] * weights >> drop).sum(axis=-1)


def activation(a: np.ndarray) -> np.ndarray:
    """gc_activation in the paper's form: h = Gamma(a) = a (beta - theta |a|).

    The slope is truncated, so h stays below +1; at a = 0 it is +1, which does not fit its 18 bits, but then h is 0
    whatever it wraps to. In LSB of h, h - Gamma(a) lies in (-2, 0] for a >= 0 and in (-1, 1] for a < 0: up to one
    from the slope (half its LSB times |a| < 2), up to one from the product.
    """
    slope = (2 ** (q.PREACTIVATION_FRACTION + 2) - np.abs(a)) >> 1
    return a * slope >> (q.PREACTIVATION_FRACTION + q.SLOPE_FRACTION - q.HIDDEN_FRACTION)


def activate(a: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """Codes of a to those of h, in the form of a network."""
    return vertex_activation(a, fixed) if fixed.is_lean else activation(a)


def vertex_activation(a: np.ndarray, fixed: FixedNetwork | None = None) -> np.ndarray:
    """gc_activation in the lean form: h = sign(a) (1 - u^2), u = 1 - |a|/2.

    The code of u is the lower bits of a, inverted where a >= 0, and so are h of u^2 and its sign: codes stand for the
    middle of their interval, on both sides alike. In LSB of h, h - Gamma(a + 1/2 LSB) lies in (-1, 1] for a >= 0 and in
    [-2, 0) for a < 0: up to one from the truncation of u^2, up to one from the half LSB of u, squared.

    In the serial form, which fixed may name, u^2 is that of serial_square.
    """
    half = 2 ** (q.OPERAND_BITS - 1)
    u = np.where(a < 0, a + half, half - 1 - a)
    squared = serial_square(u, fixed) >> half_u_shift(fixed) + 1 if fixed and fixed.is_serial else u * u >> _U_BITS
    g = squared - half
    return np.where(a < 0, g, ~g)


def serial_square(u: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """gc_core_serial: u^2 as its sum holds it, u/2 + u t, t = u - 1/2 as a weight, which may have too few bits for it.

    With e bits of t lost, u^2 is up to 2^e - 1 LSB of h below that of vertex_activation, and 2^-half_u_shift of one.
    """
    t = u - 2 ** (_U_BITS - 1) >> lost_bits(fixed)
    return (u << half_u_shift(fixed)) + (u * t >> fixed.output_product_drop)


def serial_square_interval(fixed: FixedNetwork) -> tuple[int, int]:
    """Lowest and highest code of serial_square and of its terms, which are monotonic in u but u t."""
    u = np.arange(2**_U_BITS)
    return int((serial_square(u, fixed) - (u << half_u_shift(fixed))).min()), int(serial_square(u, fixed).max())


def lost_bits(fixed: FixedNetwork) -> int:
    """Of t, which a weight of the serial form has no place for."""
    return max(_U_BITS - fixed.weight_bits, 0)


def half_u_shift(fixed: FixedNetwork) -> int:
    """Places from u to u/2 in the sum of the serial form; one more to the LSB of h."""
    return _U_BITS - 1 - lost_bits(fixed) - fixed.output_product_drop


def output_layer(h: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """gc_output_layer: codes of h (..., h) to the output sums (..., n)."""
    return _sums(h, fixed.output_weights, fixed.output_product_drop) + fixed.output_bias


def output_scaler(total: np.ndarray, fixed: FixedNetwork) -> tuple[np.ndarray, np.ndarray]:
    """gc_output_scaler: output sums (..., n) to forces in mN (..., n), and whether each y saturated."""
    y, is_saturated = saturate(total >> fixed.output_drop, fixed.y_bits)
    return y * fixed.output_scale >> fixed.output_scale_fraction, is_saturated


def core(count: np.ndarray, fixed: FixedNetwork) -> CoreOutput:
    """gc_core: encoder counts (..., n) to holding forces in mN (..., n) with their flags."""
    x, is_clamped = input_stage(np.asarray(count, dtype=np.int64), fixed)
    a = hidden_lane(x, fixed)
    force_mn, is_saturated = output_scaler(output_layer(activate(a, fixed), fixed), fixed)
    return CoreOutput(force_mn, is_clamped, is_saturated)


def current_scaler(force_mn: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """gc_current_scaler: motor currents in uA (..., n), rounded, from efforts in mN or mNm: i = f / K_t, K_t per axis.

    A current that does not fit saturates; see current_saturates.
    """
    return saturate(_current(force_mn, fixed), q.CURRENT_BITS)[0]


def current_saturates(force_mn: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    """Whether the motor current of each axis (..., n) does not fit, which counts as a saturated effort."""
    return saturate(_current(force_mn, fixed), q.CURRENT_BITS)[1]


def _current(force_mn: np.ndarray, fixed: FixedNetwork) -> np.ndarray:
    half = 1 << fixed.current_scale_fraction - 1
    return force_mn * fixed.current_scale + half >> fixed.current_scale_fraction
