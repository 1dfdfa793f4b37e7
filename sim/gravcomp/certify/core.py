"""gc_core over boxes of poses: Taylor models of the forces that the VHDL computes, every dropped bit in their radius.

Between two truncations the core is a real function of its input: it is followed as one, in the integers that the
hardware holds, and what a truncation can do is an interval of known ends around it.

    count = q / unit + [-1/2, 1/2], clamped         x = scale (count - dropped) - [0, 1) LSB, or sine and cosine
    a = W x + b - [0, 1) LSB, saturated             h = Gamma(a) + [-1 - |a|/2, 0] LSB for a >= 0, [-1, |a|/2] below
    y = V h + b - [0, 1) LSB, saturated             force = scale y - [0, 1) mN

An error of x reaches the force through the gradient of the whole network, not through each neuron at its worst; an
error of a and of h through the slope of its own neuron. Sums never overflow: ``gravcomp formats`` proves their widths.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gravcomp.certify.taylor import ROUNDOFF, Taylor
from gravcomp.core import formats as q
from gravcomp.core.formats import FixedNetwork
from gravcomp.network.inputs import SIN_COS
from gravcomp.robot.machine import Drive
from gravcomp.twin.sin_cos import ERROR_LSB, PHASE_ERROR_LSB

# Gamma(a) = -1 + sum of weight max(a - knot, 0)^2.
_KNOTS, _WEIGHTS = (-2.0, 0.0, 2.0), (0.25, -0.5, 0.25)
_LSB_A, _LSB_H = 2.0**-q.PREACTIVATION_FRACTION, 2.0**-q.HIDDEN_FRACTION
_SATURATED = 2.0**-33  # Gamma at the largest code of a, below 2 by one LSB, is off by the square of that over 4
_ROUNDINGS = 64 * ROUNDOFF  # of sums of up to 60 products
_HALF_COUNT = 0.5 + 1e-6  # rounding of the position to a count, itself rounded


@dataclass(frozen=True)
class Enclosure:
    """Forces (n models), N or Nm, over a batch of boxes. spread (n variables, batch): how much of the radius each
    variable of the box is to blame for, to split there."""

    forces: list[Taylor]
    spread: np.ndarray


def core_forces(positions: list[Taylor], fixed: FixedNetwork, drive: Drive) -> Enclosure:
    """What gc_core answers over boxes at positions q (n models), m or rad."""
    x, x_error = _inputs(positions, fixed, drive)
    a, a_weights = _hidden_sum(x, x_error, fixed)
    reach = a.reach
    low, high = a.constant - reach, a.constant + reach
    h, bend_error = _gamma(a, low, high)
    spare = np.abs(a_weights) @ x_error + _LSB_A
    slope_low, slope_high = _slopes(low - spare, high + spare)
    h_middle, h_error = _truncated_products(low - spare, high + spare)
    h_error = h_error + slope_high * _LSB_A / 2 + _SATURATED
    v = np.ldexp(fixed.output_weights.astype(float), -fixed.output_weight_fraction)
    through = _through_inputs(v, a_weights, slope_low, slope_high, x_error)
    y = _output_sum(h, h_middle, np.abs(v) @ h_error + through, v, fixed)
    part = np.abs(a.linear) / np.maximum(np.abs(a.linear).sum(axis=0), 1e-300)
    spread = (part * (bend_error * np.abs(v).max(axis=0)[:, None])).sum(axis=1)
    return Enclosure([_force(y, k, fixed) for k in range(fixed.n_axes)], spread)


def _inputs(positions: list[Taylor], fixed: FixedNetwork, drive: Drive) -> tuple[Taylor, np.ndarray]:
    """All inputs x as one model (p, N), in the middle of what truncation leaves, and how far x can be from it."""
    every = []
    for axis, (position, kind) in enumerate(zip(positions, fixed.inputs, strict=True)):
        stage = _sine_and_cosine if kind == SIN_COS else _scaled
        every += stage(position, axis, fixed, float(drive.counts_per_unit[axis]))
    models, errors = zip(*every, strict=True)
    return _joined(models), np.stack(np.broadcast_arrays(*errors, models[0].radius)[:-1])


def _scaled(position: Taylor, axis: int, fixed: FixedNetwork, counts_per_unit: float):
    """x of an axis as it stands, clamped, and its error."""
    lsb, shift = 2.0**-fixed.x_fraction, int(fixed.count_shift[axis])
    per_count = math.ldexp(
        int(fixed.input_scale[axis]), -int(fixed.input_scale_fraction[axis]) - fixed.x_fraction - shift
    )
    dropped = (2.0**shift - 1) / 2
    low, high = (end * counts_per_unit for end in position.bounds())
    beyond = np.maximum(high - fixed.count_high[axis], fixed.count_low[axis] - low) + _HALF_COUNT + 1e-6
    error = per_count * (_HALF_COUNT + dropped + np.maximum(beyond, 0.0)) + lsb / 2
    return [(position * (per_count * counts_per_unit) - (per_count * dropped + lsb / 2), error)]


def _sine_and_cosine(position: Taylor, axis: int, fixed: FixedNetwork, counts_per_unit: float):
    """Both x of an axis that turns, and their error: of the count, of its phase, of the table, of the bits dropped."""
    half = 2.0 ** -(fixed.x_fraction + 1)
    angle_rad = 2.0 * np.pi * math.ldexp(PHASE_ERROR_LSB, -q.PHASE_BITS) + _HALF_COUNT / counts_per_unit + 1e-9
    error = angle_rad + math.ldexp(ERROR_LSB, -q.SIN_COS_FRACTION) + half
    return [(position.sin() - half, error), (position.cos() - half, error)]


def _joined(models: Sequence[Taylor]) -> Taylor:
    """Models of single quantities, batch (N,), as one of batch (k, N)."""
    c = np.stack([model.c for model in models], axis=1)
    return Taylor(models[0].n, c, np.stack([model.radius for model in models]))


def _hidden_sum(x: Taylor, x_error: np.ndarray, fixed: FixedNetwork) -> tuple[Taylor, np.ndarray]:
    """a of all neurons (h, N) at the middle x, half an LSB below the sum; and W (h, p)."""
    w = np.ldexp(fixed.hidden_weights.astype(float), -fixed.weight_fraction)
    bias = np.ldexp(fixed.hidden_bias.astype(float), -fixed.x_fraction - fixed.weight_fraction)[:, None] - _LSB_A / 2
    c = w @ x.c
    c[0] += bias
    radius = np.abs(w) @ (x.radius + _ROUNDINGS * x.norm) + _ROUNDINGS * np.abs(bias)
    return Taylor(x.n, c, radius), w


def _gamma(a: Taylor, low: np.ndarray, high: np.ndarray) -> tuple[Taylor, np.ndarray]:
    """Gamma of a model whose values lie in [low, high], and the part of its radius that the knots inside cost."""
    square = linear = error = 0.0
    constant = -1.0
    for knot, weight in zip(_KNOTS, _WEIGHTS, strict=True):
        s2, s1, s0, e = _ramp_squared(low - knot, high - knot)
        square, linear = square + weight * s2, linear + weight * (s1 - 2 * knot * s2)
        constant, error = constant + weight * (s0 - knot * s1 + knot**2 * s2), error + abs(weight) * e
    squared = a.square()
    c = square * squared.c + linear * a.c
    c[0] += constant
    # Sizes of the terms, before they cancel, carry the rounding of all that is computed here.
    size = 8.0 + 4 * np.maximum(np.abs(low), np.abs(high)) ** 2
    radius = np.abs(square) * squared.radius + np.abs(linear) * a.radius + error + _ROUNDINGS * size
    return Taylor(a.n, c, radius * (1.0 + 2.0**-40)), error


def _ramp_squared(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """max(s, 0)^2 over [low, high] as s2 s^2 + s1 s + s0 with the error e: the best of three.

    s^2, off by s^2 below zero alone; 0, off by s^2 above; (s^2 + k r s)/2 over [-r, r], where s |s| is within
    (sqrt 2 - 1)^2 r^2 of k r s, k = 2 (sqrt 2 - 1).
    """
    below, above = np.maximum(-low, 0.0) ** 2 / 2, np.maximum(high, 0.0) ** 2 / 2
    r = np.maximum(np.abs(low), np.abs(high))
    k = np.sqrt(2.0) - 1.0
    middle = (k * r) ** 2 / 2 * (1.0 + 1e-12)
    is_middle = middle < np.minimum(below, above)
    is_square = ~is_middle & (below <= above)
    s2 = np.where(is_middle, 0.5, np.where(is_square, 1.0, 0.0))
    s1 = np.where(is_middle, k * r, 0.0)
    s0 = np.where(is_middle, 0.0, np.where(is_square, -below, above))
    return s2, s1, s0, np.where(is_middle, middle, np.minimum(below, above))


def _slopes(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest slope of Gamma over [low, high]: 1 - |a|/2, or 0 beyond 2."""
    nearest = np.maximum(np.maximum(low, -high), 0.0)
    farthest = np.maximum(np.abs(low), np.abs(high))
    return np.maximum(1.0 - farthest / 2, 0.0), np.maximum(1.0 - nearest / 2, 0.0)


def _truncated_products(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middle and half of what the truncations of gc_activation add to Gamma of a in [low, high]."""
    least = -1.0 - np.clip(high, 0.0, 2.0) / 2
    most = np.clip(-low, 0.0, 2.0) / 2
    return (least + most) / 2 * _LSB_H, (most - least) / 2 * _LSB_H


def _through_inputs(v, w, slope_low, slope_high, x_error) -> np.ndarray:
    """What errors of x (p, N) do to the sums V Gamma(W x), (n, N): by the gradient, all neurons together."""
    each = (v[:, None, :] * w.T[None]).reshape(-1, w.shape[0])  # (n p, h)
    gradient = np.abs(each @ ((slope_high + slope_low) / 2)) + np.abs(each) @ ((slope_high - slope_low) / 2)
    return (gradient.reshape(len(v), -1, gradient.shape[-1]) * x_error).sum(axis=1)


def _output_sum(h: Taylor, h_middle: np.ndarray, error: np.ndarray, v: np.ndarray, fixed: FixedNetwork) -> Taylor:
    """y of all axes (n, N), saturated."""
    half = 2.0 ** -(fixed.y_fraction + 1)
    bias = np.ldexp(fixed.output_bias.astype(float), -q.HIDDEN_FRACTION - fixed.output_weight_fraction)[:, None] - half
    c = v @ h.c
    c[0] += bias + v @ h_middle
    radius = np.abs(v) @ (h.radius + _ROUNDINGS * (h.norm + 1.0)) + error + half + _ROUNDINGS * (1.0 + np.abs(bias))
    y = Taylor(h.n, c, radius * (1.0 + 2.0**-40))
    low, high = y.bounds()
    limit = 2.0 ** (q.OPERAND_BITS - 1 - fixed.y_fraction)
    y.radius = y.radius + np.maximum(np.maximum(high - limit * (1.0 - 2.0**-17), -limit - low), 0.0)
    return y


def _force(y: Taylor, axis: int, fixed: FixedNetwork) -> Taylor:
    """Force or torque of an axis, N or Nm, in the middle of the last truncation."""
    mn = float(np.ldexp(float(fixed.output_scale[axis]), fixed.y_fraction - fixed.output_scale_fraction[axis]))
    force_mn = Taylor(y.n, y.c[:, axis], y.radius[axis]) * mn - 0.5
    force_mn.radius = force_mn.radius + 0.5
    return force_mn * 1e-3
