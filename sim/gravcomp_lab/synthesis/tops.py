"""Area and clocks of whole tops, as a user instantiates them, on ECP5; their ports are on scan chains."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from statistics import median

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.parallel import executor
from gravcomp_lab.forms import form_copy
from gravcomp_lab.synthesis import place_route
from gravcomp_lab.synthesis.around import scan_cells, scanned
from gravcomp_lab.synthesis.place_route import PlacedDesign, place_and_route
from gravcomp_lab.synthesis.survey import MULTIPLIER, finish, machine_sources
from gravcomp_lab.synthesis.verilog import to_verilog
from gravcomp_lab.synthesis.yosys import Netlist, synthesise

# Clocks of each top, and how the names of the ports of each begin.
CLOCKS: dict[str, Mapping[str, tuple[str, ...]]] = {
    "gc_core": {"clk": ()},
    "gc_force_path": {"clk": ()},
    "gc_system": {"clk": (), "s_axi_aclk": ("s_axi_", "irq")},
}
# TRELLIS_COMB and multipliers of the parts, the smallest first.
_PARTS = {"25k": (24288, 28), "45k": (43848, 72), "85k": (83640, 156)}
# Asked of every clock: a system that is a third of its part is not routed in half an hour when it is asked for 400.
GOAL_MHZ = 100
# Of a part's cells, what the router still finds its way through.
_FULL = 0.9


@dataclass(frozen=True)
class Top:
    """A top with its generics, in a form of the network."""

    entity: str
    lanes: int
    loadable: bool
    form: str

    def __str__(self) -> str:
        return f"{self.entity} {self.lanes} {'loadable' if self.loadable else 'ROM'} {self.form}"


@dataclass(frozen=True)
class PlacedTop:
    """A top on the smallest part that holds it: cells of its own, and each run by speed grade and seed."""

    top: Top
    part: str
    cells: dict[str, int]
    runs: dict[tuple[int, int], PlacedDesign]


def place_tops(
    tops: Sequence[Top],
    weights: Path,
    *,
    speeds: Sequence[int],
    seeds: Sequence[int],
    rtl: Path,
    build: Path,
    jobs: int,
    backend: str = "threading",
) -> list[PlacedTop]:
    """Synthesise, place and route each top for a machine folder, at every speed grade and seed.

    Files go to build/tops; a run that was done before with the same netlist is not repeated. Raises InputError when a
    tool fails, or no part holds a top.
    """
    place_route.prepare()
    cases = [(top, speed, seed) for top in tops for speed in speeds for seed in seeds]
    with tqdm(total=len(tops) + len(cases), unit="run") as bar, executor(backend, jobs) as pool:
        made = [pool.submit(_netlist, top, weights, rtl, build / "tops") for top in tops]
        netlists = {top: netlist for (top,), netlist in finish(bar, made)}
        parts = {top: part_of(top, netlists[top].cells) for top in tops}
        placed = [pool.submit(_place, case, netlists[case[0]], parts[case[0]], build / "tops") for case in cases]
        runs = dict(finish(bar, placed))
    of = {top: {at: runs[top, *at] for at in product(speeds, seeds)} for top in tops}
    return [PlacedTop(top, parts[top], _own_cells(top, netlists[top]), of[top]) for top in tops]


def part_of(top: Top, cells: Mapping[str, int]) -> str:
    """The smallest part that holds the cells of an ECP5 netlist. Raises InputError when there is none."""
    comb, multipliers = comb_of(cells), cells.get("MULT18X18D", 0)
    for part, (most_comb, most_multipliers) in _PARTS.items():
        if comb <= _FULL * most_comb and multipliers <= most_multipliers:
            return part
    raise InputError(f"{top}: {comb} TRELLIS_COMB and {multipliers} multipliers fit no part; take fewer lanes or axes")


def comb_of(cells: Mapping[str, int]) -> int:
    """TRELLIS_COMB of a netlist: a LUT each, two for a carry cell, and six for a distributed RAM of 16 words of 4."""
    return cells.get("LUT4", 0) + 2 * cells.get("CCU2C", 0) + 6 * cells.get("TRELLIS_DPR16X4", 0)


def _netlist(top: Top, weights: Path, rtl: Path, folder: Path) -> tuple[tuple[Top], Netlist]:
    out = folder / str(top).replace(" ", "-")
    sources = machine_sources(rtl, form_copy(weights, folder, top.form), out)
    generics = {"lanes_g": top.lanes, "loadable_g": str(top.loadable).lower()}
    verilog = to_verilog(sources, top.entity, generics, out / "top.v")
    around = scanned(CLOCKS[top.entity])
    return (top,), synthesise(verilog, top.entity, "ecp5", out, mapping=rtl / MULTIPLIER, around=around)


def _own_cells(top: Top, netlist: Netlist) -> dict[str, int]:
    """The cells less those of the scan chains."""
    luts, flip_flops = scan_cells(netlist.ports, CLOCKS[top.entity])
    cells = netlist.cells
    return {**cells, "LUT4": cells["LUT4"] - luts, "TRELLIS_FF": cells["TRELLIS_FF"] - flip_flops}


def _place(case: tuple[Top, int, int], netlist: Netlist, part: str, folder: Path):
    top, speed, seed = case
    out = folder / f"{top}-{speed}-{seed}".replace(" ", "-")
    return case, place_and_route(netlist.json, part=part, speed=speed, seed=seed, out=out, goal_mhz=GOAL_MHZ)


HEAD = (
    "| top | lanes | constants | form | part | TRELLIS_COMB | TRELLIS_FF | MULT18X18D | DP16KD | MHz by speed grade |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)


def row(placed: PlacedTop) -> str:
    """A line of the table: cells of the netlist, and the clocks as least, median, most of the seeds by speed grade."""
    top, cells = placed.top, placed.cells
    counts = comb_of(cells), *(cells.get(name, 0) for name in ("TRELLIS_FF", "MULT18X18D", "DP16KD"))
    constants = "loadable" if top.loadable else "ROM"
    columns = [top.entity, top.lanes, constants, top.form, f"LFE5U-{placed.part.upper().replace('K', 'F')}", *counts]
    return f"| {' | '.join(map(str, columns))} | {clocks(placed)} |"


def clocks(placed: PlacedTop) -> str:
    """The clocks of a top in words."""
    told = []
    for speed in sorted({speed for speed, _ in placed.runs}):
        found = [run for (at, _), run in sorted(placed.runs.items()) if at == speed]
        for name in CLOCKS[placed.top.entity]:
            reached = sorted(run.clocks[name].mhz for run in found)
            told.append(f"{speed}: {name} {_spread(reached)}")
    return "; ".join(told)


def _spread(reached: Sequence[float]) -> str:
    if len(reached) == 1:
        return f"{reached[0]:.0f}"
    return f"{median(reached):.0f} ({reached[0]:.0f}-{reached[-1]:.0f})"


def slowest(placed: PlacedTop) -> list[str]:
    """For each clock of the quickest speed grade's first run: where its slowest path begins and ends."""
    run = placed.runs[min(placed.runs)]
    return [
        f"- {placed.top}, {name}: `{run.clocks[name].path_from}` to `{run.clocks[name].path_to}`, "
        f"{run.clocks[name].path_ns:.1f} ns"
        for name in CLOCKS[placed.top.entity]
    ]
