"""Operation counts that come out of running the ordinary code on numbers that count.

A ``Counted`` stands in for a float, alone or in NumPy object arrays. Free are: sign changes, absolute values,
comparisons and choices; multiplying by an exact constant 0 or +-1; adding an exact constant 0 (structural zeros that
hardware does not build). Operations among constants are free too, as they are done once, at design time.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np

from gravcomp.network.activation import gamma
from gravcomp.network.inputs import SIN_COS, axis_of_input
from gravcomp.network.weights import Network
from gravcomp.robot.spheiro.kinematics import axes_from_squares, quaternion_squares
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.statics import forces_from_axes
from gravcomp.twin.sin_cos import PLACE_BITS


@dataclass
class OperationCount:
    """How many operations of each kind ran. ``sums`` counts additions, subtractions and n-ary sums, each as one."""

    multiplications: int = 0
    sums: int = 0
    divisions: int = 0
    square_roots: int = 0
    trigonometric: int = 0

    @property
    def total(self) -> int:
        return sum(getattr(self, f.name) for f in fields(self))


class Counted:
    """A real number that counts the operations done with it in ``count``."""

    __slots__ = ("count", "value")

    def __init__(self, value: float, count: OperationCount):
        self.value = float(value)
        self.count = count

    def __repr__(self) -> str:
        return f"Counted({self.value!r})"

    def _new(self, value: float, kind: str | None = None) -> "Counted":
        if kind is not None:
            setattr(self.count, kind, getattr(self.count, kind) + 1)
        return Counted(value, self.count)

    def __add__(self, other):
        if _is_constant(other, 0.0):
            return self
        return self._new(self.value + _value(other), "sums")

    __radd__ = __add__

    def __sub__(self, other):
        return self if _is_constant(other, 0.0) else self._new(self.value - _value(other), "sums")

    def __rsub__(self, other):
        return -self if _is_constant(other, 0.0) else self._new(_value(other) - self.value, "sums")

    def __mul__(self, other):
        if _is_constant(other, 0.0):
            return 0.0
        if _is_constant(other, 1.0, -1.0):
            return self._new(self.value * other)
        return self._new(self.value * _value(other), "multiplications")

    __rmul__ = __mul__

    def __truediv__(self, other):
        if _is_constant(other, 1.0, -1.0):
            return self._new(self.value / other)
        return self._new(self.value / _value(other), "divisions")

    def __rtruediv__(self, other):
        return 0.0 if _is_constant(other, 0.0) else self._new(_value(other) / self.value, "divisions")

    def __neg__(self):
        return self._new(-self.value)

    def __abs__(self):
        return self._new(abs(self.value))

    def __lt__(self, other):
        return self.value < _value(other)

    def __le__(self, other):
        return self.value <= _value(other)

    def __gt__(self, other):
        return self.value > _value(other)

    def __ge__(self, other):
        return self.value >= _value(other)

    def __eq__(self, other):
        return self.value == _value(other)

    __hash__ = None

    def __float__(self):
        return self.value

    def clip(self, low: float, high: float, out=None):
        """Called by np.clip. A clipped value still counts: hardware multiplies it all the same."""
        return self._new(min(max(self.value, low), high))

    def sqrt(self):
        """Called by np.sqrt, as are the trigonometric functions by theirs."""
        return self._new(math.sqrt(self.value), "square_roots")

    def sin(self):
        return self._new(math.sin(self.value), "trigonometric")

    def cos(self):
        return self._new(math.cos(self.value), "trigonometric")

    def tan(self):
        return self._new(math.tan(self.value), "trigonometric")

    def arccos(self):
        return self._new(math.acos(self.value), "trigonometric")

    def arctan2(self, other):
        return self._new(math.atan2(self.value, _value(other)), "trigonometric")


def _value(number) -> float:
    return number.value if isinstance(number, Counted) else float(number)


def _is_constant(number, *values: float) -> bool:
    return not isinstance(number, Counted) and number in values


def counted(values: np.ndarray, count: OperationCount) -> np.ndarray:
    """An object array of Counted, of the shape of values."""
    return np.vectorize(lambda value: Counted(value, count), otypes=[object])(values)


def n_ary_sum(terms: Iterable):
    """The sum of all terms, counted as one: an adder tree or an accumulator of the hardware."""
    terms = list(terms)
    numbers = [term for term in terms if isinstance(term, Counted)]
    total = math.fsum(_value(term) for term in terms)
    return numbers[0]._new(total, "sums") if numbers else total


def statics_on_counted(q_m: np.ndarray, p: RobotParameters) -> tuple[np.ndarray, OperationCount]:
    """Holding forces (3,), N, at joint positions q (3,), m, by the closed-form statics, and what they cost."""
    count = OperationCount()
    axes = axes_from_squares(quaternion_squares(counted(q_m, count), p))
    return forces_from_axes(axes, p).astype(float), count


def lean_on_counted(network: Network, q: np.ndarray) -> tuple[np.ndarray, OperationCount]:
    """Efforts (n,), N or Nm, at joint positions q (n,), m or rad, by the lean form of the network, and what they cost.

    Both scalings are part of weights and biases; u = 1 - |a|/2 and 1 - u^2 are bits of a and of u^2, some inverted.
    """
    count = OperationCount()
    hidden_bias = network.hidden_bias - network.hidden_weights @ (network.q_offset * network.q_scale)
    output_bias = network.f_offset + network.f_scale * network.output_bias
    weights = network.hidden_weights * network.q_scale, network.f_scale[:, None] * network.output_weights
    hidden = [
        _vertex(a)
        for a in _layer([Counted(position, count) for position in q], counted(weights[0], count), hidden_bias)
    ]
    forces = _layer(np.array(hidden, dtype=object), counted(weights[1], count), output_bias)
    return np.array(forces, dtype=object).astype(float), count


def _vertex(a: Counted) -> Counted:
    u = Counted(max(1.0 - abs(a.value) / 2, 0.0), a.count)
    return Counted(math.copysign(1.0 - (u * u).value, a.value), a.count)


def network_on_counted(network: Network, q: np.ndarray) -> tuple[np.ndarray, OperationCount, OperationCount]:
    """Efforts (n,), N or Nm, at joint positions q (n,), m or rad, by the network as the hardware runs it; what they
    cost, and what sines and cosines cost beside it.

    The offsets of both normalisations are folded into the biases: x = S q, h = Gamma(W x + b_H'), f = S_f (V h + b_o').
    """
    count, apart = OperationCount(), OperationCount()
    offset = np.array([0.0 if kind == SIN_COS else 1.0 for kind in network.inputs]) * network.q_offset * network.q_scale
    hidden_bias = network.hidden_bias - network.hidden_weights @ offset[axis_of_input(network.inputs)]
    output_bias = network.output_bias + network.f_offset / network.f_scale
    # The hardware multiplies by whatever the ROM holds: a weight that happens to be 0 or 1 is a product all the same.
    weights = counted(network.hidden_weights, count), counted(network.output_weights, count)
    x = []
    for kind, position, scale in zip(network.inputs, q, network.q_scale, strict=True):
        is_turn = kind == SIN_COS
        x += turn_on_counted(position, count, apart) if is_turn else [Counted(position, count) * Counted(scale, count)]
    hidden = np.array([gamma(h) for h in _layer(x, weights[0], hidden_bias)], dtype=object)
    forces = np.array(_layer(hidden, weights[1], output_bias), dtype=object) * counted(network.f_scale, count)
    return forces.astype(float), count, apart


def turn_on_counted(q_rad: float, count: OperationCount, apart: OperationCount) -> list[Counted]:
    """Sine and cosine as gc_phase and gc_sin_cos make them, of an encoder with 2^20 counts per turn.

    count: what the product that gives each of them costs; apart: all the rest.
    """
    high, low = divmod(q_rad / (2 * np.pi) * 2**20, 2**16)
    parts = [(half, part) for half, step in ((low, 2.0**-20), (high, 2.0**-4)) for part in (step, 0.0)]
    turns = n_ary_sum(Counted(half, apart) * Counted(part, apart) for half, part in parts).value
    place = round(turns * 2**PLACE_BITS) / 2**PLACE_BITS
    b = (Counted(turns - place, apart) * Counted(2 * np.pi, apart)).value
    sine, cosine = np.sin(2 * np.pi * place), np.cos(2 * np.pi * place)
    products = [Counted(b, count) * Counted(slope, count) for slope in (cosine, -sine)]
    sums = [Counted(at_place, apart) + product for at_place, product in zip((sine, cosine), products, strict=True)]
    return [Counted(total.value, count) for total in sums]


def _layer(x: np.ndarray, weights: np.ndarray, bias: np.ndarray) -> list:
    return [n_ary_sum([*(row * x), b]) for row, b in zip(weights, bias, strict=True)]


def count_statics_operations(p: RobotParameters) -> OperationCount:
    """Operations of joint positions -> holding forces by the closed-form statics (the same at every pose)."""
    return statics_on_counted(0.1 * p.d_m * np.array([1.0, -2.0, 3.0]), p)[1]


def count_network_operations(network: Network) -> tuple[OperationCount, OperationCount]:
    """Operations of joint positions -> forces by the network in the hardware's structure (the same at every pose), and
    those of sines and cosines."""
    return network_on_counted(network, network.q_offset)[1:]
