"""The survey as Markdown tables and as a picture."""

from collections.abc import Sequence

from gravcomp_lab.synthesis.survey import CREDIBLE_MHZ, SPEEDS, LanesResult

_PLACED = "| lanes | part | TRELLIS_COMB | TRELLIS_FF | MULT18X18D | DP16KD | interval, latency, clocks |"
_PLACED += " clock, speed 6 / 8, MHz | of three seeds, MHz | latency, ns | million inferences/s |"
_ESTIMATED = (
    "| lanes | 7-series: LUT | FF | DSP48E1 | block RAM | Gowin GW2A: LUT4 and ALU | FF | MULT18X18 | block RAM |"
)


def tables(results: Sequence[LanesResult]) -> str:
    """Markdown: what was placed on ECP5, then the estimates for 7-series and Gowin."""
    placed, estimated = [_placed_row(r) for r in results], [_estimated_row(r) for r in results]
    paths = [
        f"- lanes {r.lanes}, speed {speed}: `{r.slowest_path[speed][0]}` to `{r.slowest_path[speed][1]}`"
        for r in results
        for speed in SPEEDS
    ]
    lines = [_PLACED, _rule(_PLACED), *placed, "", _ESTIMATED, _rule(_ESTIMATED), *estimated, ""]
    lines += ["Slowest path between two registers, in the best of the seeds:", "", *paths, ""]
    return "\n".join(lines)


def _rule(header: str) -> str:
    return "|" + "---|" * (header.count("|") - 1)


def _placed_row(r: LanesResult) -> str:
    used = {name: r.cells["placed"].get(name, 0) for name in ("TRELLIS_COMB", "TRELLIS_FF", "MULT18X18D", "DP16KD")}
    used["TRELLIS_FF"] -= r.port_flip_flops
    clocks = {speed: r.quoted_mhz(speed) for speed in SPEEDS}
    capped = [f"{mhz:.0f}" + "*" * (max(r.clock_mhz[speed]) > CREDIBLE_MHZ) for speed, mhz in clocks.items()]
    columns = [
        str(r.lanes),
        f"LFE5U-{r.part.upper().replace('K', 'F')}",
        *(str(number) for number in used.values()),
        f"{r.interval}, {r.latency}",
        " / ".join(capped),
        " / ".join(f"{min(mhz):.0f}-{max(mhz):.0f}" for mhz in r.clock_mhz.values()),
        " / ".join(f"{1e3 * r.latency / mhz:.0f}" for mhz in clocks.values()),
        " / ".join(f"{mhz / r.interval:.1f}" for mhz in clocks.values()),
    ]
    return f"| {' | '.join(columns)} |"


def _estimated_row(r: LanesResult) -> str:
    xilinx, gowin = r.cells["xilinx"], r.cells["gowin"]
    columns = [
        r.lanes,
        _count(xilinx, "LUT", "SRL", "INV"),
        _count(xilinx, "FD"),
        _count(xilinx, "DSP48E1"),
        _count(xilinx, "RAMB"),
        _count(gowin, "LUT", "ALU"),
        _count(gowin, "DFF"),
        _count(gowin, "MULT18X18"),
        _count(gowin, "SP", "DP", "pROM"),
    ]
    return f"| {' | '.join(map(str, columns))} |"


def _count(cells: dict[str, int], *prefixes: str) -> int:
    return sum(number for name, number in cells.items() if name.startswith(prefixes))


def picture(results: Sequence[LanesResult]):
    """Logic cells against inferences per second, a curve per speed grade. Returns a Matplotlib figure."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator

    figure = Figure(figsize=(7.0, 4.5))
    axes = figure.add_subplot()
    comb = [r.cells["placed"]["TRELLIS_COMB"] for r in results]
    for speed, marker in zip(SPEEDS, "os", strict=True):
        rate = [r.quoted_mhz(speed) / r.interval for r in results]
        axes.loglog(rate, comb, marker, linestyle="-", label=f"speed grade {speed}")
    for r, cells in zip(results, comb, strict=True):
        text = f"{r.lanes} lane{'s' * (r.lanes > 1)}, {r.cells['placed']['MULT18X18D']} multipliers"
        rate = r.quoted_mhz(SPEEDS[0]) / r.interval
        axes.annotate(text, (rate, cells), (-8, 8), textcoords="offset points", ha="right", fontsize=8)
    axes.set_xlim(left=axes.get_xlim()[0] / 4)
    axes.set_ylim(top=axes.get_ylim()[1] * 1.3)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
    axes.set_xlabel("inferences per second, million")
    axes.set_ylabel("logic cells, TRELLIS_COMB")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(loc="lower right")
    return figure
