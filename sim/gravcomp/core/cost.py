"""What a network costs in gc_core: operations, multipliers, clocks. Sine and cosine of axes that turn come apart."""

from dataclasses import dataclass
from math import ceil, log2


@dataclass(frozen=True)
class CoreCost:
    """Of n neurons, p inputs and m axes with so many neurons per clock.

    multiplications and sums of an inference; multipliers of 18 by 18 bits (a product by theta = 1/4 is a shift);
    interval and latency in clocks, from accepted counts to efforts.
    """

    neurons: int
    inputs: int
    axes: int
    lanes: int

    @property
    def multiplications(self) -> int:
        n, p, m = self.neurons, self.inputs, self.axes
        return p + p * n + 2 * n + n * m + m

    @property
    def sums(self) -> int:
        return 2 * self.neurons + self.axes

    @property
    def multipliers(self) -> int:
        scalers = 2 if self.lanes == 1 else self.inputs + self.axes
        return self.lanes * (self.inputs + 1 + self.axes) + scalers

    @property
    def interval(self) -> int:
        return ceil(self.neurons / self.lanes)

    @property
    def latency(self) -> int:
        tree = ceil(log2(self.inputs + 1))
        if self.lanes == self.neurons > 1:
            return 18 + tree + ceil(log2(self.lanes + 1))
        shared = (2 * self.axes + 2 if self.axes > 1 else 2) if self.lanes == 1 else 0
        return 14 + tree + ceil(log2(self.lanes)) + self.interval + shared
