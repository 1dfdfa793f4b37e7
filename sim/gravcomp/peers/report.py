"""The comparison as a table and a picture."""

from collections.abc import Sequence

from gravcomp.peers.claims import Claim
from gravcomp.peers.measure import SPEEDS, Row

_HEADER = (
    "| design | COMB | FF | MULT18X18D | DP16KD | clock, MHz, speed {speeds} | latency, clocks | interval, clocks "
    "| latency, ns, speed {speeds} | inferences per us, speed {speeds} | largest error, of full scale | seeds |"
)


def table(rows: Sequence[Row]) -> str:
    """Markdown: one line per design. A latency in brackets is the one that the tool itself claims."""
    header = _HEADER.format(speeds=" / ".join(map(str, SPEEDS)))
    return "\n".join([header, "|---" * (header.count("|") - 1) + "|", *map(_line, rows)])


def claims_table(claims: Sequence[Claim]) -> str:
    """Markdown: each claim, reached or not, with its figures."""
    lines = [
        f"| {claim.text} | {'reached' if claim.is_reached else 'NOT reached'} | {claim.figures} |" for claim in claims
    ]
    return "\n".join(["| to reach | | measured |", "|---|---|---|", *lines])


def picture(ours: Sequence[Row], peers: Sequence[Row]):
    """Logic against latency at the slower speed grade, both logarithmic. Returns a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.add_subplot()
    for rows, marker, label in ((ours, "o", "this core"), (peers, "s", "other generators")):
        latency_ns = [row.latency_ns(SPEEDS[0]) for row in rows]
        axes.plot(latency_ns, [row.comb for row in rows], marker, markersize=9, label=label)
        for row, x in zip(rows, latency_ns, strict=True):
            axes.annotate(row.name, (x, row.comb), xytext=(8, 6), textcoords="offset points", fontsize=9)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(x=0.25, y=0.15)
    axes.set_xlabel(f"latency of an inference, ns (LFE5U, speed {SPEEDS[0]})")
    axes.set_ylabel("logic, TRELLIS_COMB")
    axes.grid(which="both", alpha=0.3)
    axes.legend()
    return figure


def _line(row: Row) -> str:
    claimed = "" if row.latency_claimed == row.latency else f" ({row.latency_claimed})"
    cells = [row.name, row.comb, row.ff, row.mult, row.ram, _both(row.clock_mhz[speed] for speed in SPEEDS)]
    cells += [f"{row.latency}{claimed}", row.interval, _both(row.latency_ns(speed) for speed in SPEEDS)]
    cells += [_both((row.rate_mhz(speed) for speed in SPEEDS), ".3g"), f"{row.error:.1e}", row.n_seeds]
    return "| " + " | ".join(map(str, cells)) + " |"


def _both(values, form: str = ".0f") -> str:
    return " / ".join(format(value, form) for value in values)
