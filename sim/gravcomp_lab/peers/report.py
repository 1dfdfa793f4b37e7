"""The comparison as a table and a picture."""

from collections.abc import Sequence

from gravcomp_lab.peers.claims import PeerClaim
from gravcomp_lab.peers.measure import PeerRow, common_speeds

_HEADER = (
    "| design | COMB | FF | MULT18X18D | DP16KD | clock, MHz, speed {speeds} | latency, clocks | interval, clocks "
    "| latency, ns, speed {speeds} | inferences per us, speed {speeds} | largest error, of full scale | seeds |"
)

_VERDICT = {True: "reached", False: "NOT reached", None: "not measured"}


def table(rows: Sequence[PeerRow]) -> str:
    """Markdown: one line per design. A latency in brackets is the one that the tool itself claims."""
    speeds = common_speeds(rows)
    header = _HEADER.format(speeds=" / ".join(map(str, speeds)))
    return "\n".join([header, "|---" * (header.count("|") - 1) + "|", *(_line(row, speeds) for row in rows)])


def claims_table(claims: Sequence[PeerClaim]) -> str:
    """Markdown: each claim, reached or not, with its figures."""
    lines = [f"| {claim.text} | {_VERDICT[claim.is_reached]} | {claim.figures} |" for claim in claims]
    return "\n".join(["| to reach | | measured |", "|---|---|---|", *lines])


def picture(ours: Sequence[PeerRow], peers: Sequence[PeerRow]):
    """Logic against latency at the slower speed grade, both logarithmic. Returns a Matplotlib figure."""
    from matplotlib.figure import Figure

    speed = common_speeds([*ours, *peers])[0]
    figure = Figure(figsize=(9, 4.5), layout="constrained")
    axes = figure.add_subplot()
    for rows, marker in ((ours, "o"), (peers, "s")):
        for row in rows:
            axes.loglog(row.latency_ns(speed), row.comb, marker, markersize=10, linestyle="", label=row.name)
    axes.margins(0.1)
    axes.set_xlabel(f"latency of an inference, ns (LFE5U, speed {speed})")
    axes.set_ylabel("logic, TRELLIS_COMB")
    axes.grid(which="both", alpha=0.3)
    figure.legend(loc="outside right center")
    return figure


def _line(row: PeerRow, speeds: Sequence[int]) -> str:
    claimed = "" if row.latency_claimed == row.latency else f" ({row.latency_claimed})"
    cells = [row.name, row.comb, row.ff, row.mult, row.ram, _both(row.clock_mhz[speed] for speed in speeds)]
    cells += [f"{row.latency}{claimed}", row.interval, _both(row.latency_ns(speed) for speed in speeds)]
    cells += [_both((row.rate_mhz(speed) for speed in speeds), ".3g"), f"{row.error:.1e}", row.n_seeds]
    return "| " + " | ".join(map(str, cells)) + " |"


def _both(values, form: str = ".0f") -> str:
    return " / ".join(format(value, form) for value in values)
