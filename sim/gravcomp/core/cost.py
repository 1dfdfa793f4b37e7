"""What a network costs in gc_core, in either form, and in gc_core_serial: operations, multipliers, clocks; and the
clocks of what stands behind it in gc_force_path.

Sines and cosines cost no operations here.
"""

from dataclasses import dataclass
from math import ceil, log2

from gravcomp.facts import COMPENSATOR_CLOCKS, CURRENT_SCALER_CLOCKS

_TURN_MULTIPLIERS = 7  # from a count to sine and cosine: gc_phase and gc_sin_cos
_TURN_CLOCKS = 11  # what gc_turn_stage takes more than gc_input_scaler


@dataclass(frozen=True)
class CoreCost:
    """Of n neurons, p inputs and m axes with so many neurons per clock; p - m axes give sine and cosine as inputs.

    multiplications and sums of an inference, without those that make sines and cosines; multipliers of 18 by 18 bits,
    at most (a product by theta = 1/4 is a shift, one by a constant may be); interval and latency in clocks, from
    accepted counts to efforts. is_lean: without scalers, Gamma as a square. is_serial: so, and in turn on a single
    multiplier of 18 by 16 bits.
    """

    neurons: int
    inputs: int
    axes: int
    lanes: int
    is_lean: bool = False
    is_serial: bool = False

    @property
    def multiplications(self) -> int:
        n, p, m = self.neurons, self.inputs, self.axes
        if self.is_lean:
            return p * n + n + n * m
        return p + p * n + 2 * n + n * m + m

    @property
    def sums(self) -> int:
        return (1 if self.is_lean else 2) * self.neurons + self.axes

    @property
    def turns(self) -> int:
        return self.inputs - self.axes

    @property
    def multipliers(self) -> int:
        if self.is_serial:
            return 1
        if self.is_lean:
            return self.lanes * (self.inputs + 1 + self.axes)
        positions = self.axes - self.turns
        scalers = min(positions, 1) + 1 if self._scalers_share else positions + self.axes
        ways = min(self.turns, 1) if self._turns_share else self.turns
        return self.lanes * (self.inputs + 1 + self.axes) + scalers + _TURN_MULTIPLIERS * ways

    @property
    def interval(self) -> int:
        if self.is_serial:
            return self.latency
        return ceil(self.neurons / self.lanes)

    @property
    def latency(self) -> int:
        if self.is_serial:
            neurons, taps = max(self.neurons, 6), max(self.inputs, 3)
            return (neurons + 1) * (taps + 1) + neurons * self.axes + 5
        is_once = self.interval == 1 < self.neurons
        trees = ceil(log2(self.inputs + 1)) + ceil(log2(self.lanes + is_once))
        if self.is_lean:
            return 8 + (3 if is_once else 0) + trees + self.interval
        scaler = self.axes if self._scalers_share and self.axes > 1 else 0
        turns = _TURN_CLOCKS + (self.turns if self._turns_share and self.turns > 1 else 0)
        stages = 14 + (3 if is_once else 2 if self.lanes == 1 else 0)
        return stages + trees + self.interval + (turns if self.turns else scaler) + scaler

    @property
    def axes_in_turn(self) -> int:
        """Axes that share tables and multipliers behind the core: as many as fit between two results and divide all."""
        return max(k for k in range(1, self.axes + 1) if k <= self.interval and self.axes % k == 0)

    def clocks_behind(self, is_compensated: bool = True) -> int:
        """From the core's efforts, with which the compensator takes counts and speeds, to those of gc_force_path: both
        stages behind it, and a clock to hold what goes out."""
        compensator = compensator_clocks(self.axes_in_turn) if is_compensated else 0
        return compensator + current_scaler_clocks(self.axes_in_turn) + 1

    @property
    def _scalers_share(self) -> bool:
        """Whether one multiplier scales all positions, and one all efforts."""
        return self.lanes == 1 and self.interval >= self.axes

    @property
    def _turns_share(self) -> bool:
        """Whether the lanes leave a clock for each axis that turns."""
        return self.interval >= self.turns


def compensator_clocks(in_turn: int) -> int:
    """Latency of gc_compensator with so many axes to a unit, clocks."""
    return COMPENSATOR_CLOCKS + in_turn - 1


def current_scaler_clocks(in_turn: int) -> int:
    """Latency of gc_current_scaler with so many axes to a multiplier, clocks."""
    return CURRENT_SCALER_CLOCKS + (in_turn if in_turn > 1 else 0)
