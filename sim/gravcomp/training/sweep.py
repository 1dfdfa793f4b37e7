"""Sizes of a network side by side: error against neurons, operations, multipliers and clocks."""

import io
from collections.abc import Mapping
from dataclasses import dataclass

from matplotlib.figure import Figure

from gravcomp.core.cost import CoreCost
from gravcomp.network.weights import Network

LANES = (1, 4)


@dataclass(frozen=True)
class Size:
    """A trained network: errors in N or N m on unseen poses, RMS also in percent of the RMS effort; inputs, axes."""

    neurons: int
    inputs: int
    axes: int
    rms: float
    rms_percent: float
    largest: float

    @classmethod
    def of(cls, network: Network, metrics: Mapping[str, float]) -> "Size":
        n_inputs = network.hidden_weights.shape[1]
        errors = (metrics[name] for name in ("test_rms", "test_rms_percent", "largest"))
        return cls(network.n_hidden, n_inputs, network.n_axes, *errors)

    def cost(self, lanes: int) -> CoreCost:
        return CoreCost(self.neurons, self.inputs, self.axes, min(lanes, self.neurons))


def table(found: list[Size], unit: str) -> str:
    """Markdown, a row per size."""
    by_lanes = "".join(f" multipliers, {n} a clock | interval, latency, {n} a clock |" for n in LANES)
    lines = [
        f"| neurons | RMS, {unit} | RMS, % of RMS effort | largest, {unit} | multiplications | sums |{by_lanes}",
        "|" + "---|" * (6 + 2 * len(LANES)),
    ]
    for one in found:
        costs = [one.cost(lanes) for lanes in LANES]
        clocks = "".join(f" {c.multipliers} | {c.interval}, {c.latency} |" for c in costs)
        lines.append(
            f"| {one.neurons} | {one.rms:.4g} | {one.rms_percent:.3g} | {one.largest:.3g} | "
            f"{costs[0].multiplications} | {costs[0].sums} |{clocks}"
        )
    return "\n".join(lines) + "\n"


def picture(found: list[Size]) -> bytes:
    """Error against neurons, against multiplications and against latency of one lane, as PNG."""
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    axes = {
        "neurons": [one.neurons for one in found],
        "multiplications per inference": [one.cost(1).multiplications for one in found],
        "clocks, one neuron a clock": [one.cost(1).latency for one in found],
    }
    for panel, (name, values) in zip(figure.subplots(1, len(axes), sharey=True), axes.items(), strict=True):
        panel.loglog(values, [one.rms_percent for one in found], "o-", base=10)
        panel.set_xticks(values, [str(value) for value in values], rotation=45)
        panel.minorticks_off()
        panel.set_xlabel(name)
        panel.grid(alpha=0.3)
    figure.axes[0].set_ylabel("RMS error, % of RMS effort")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=120)
    return stream.getvalue()
