"""Area and clock of the core per number of lanes: synthesis, then place and route over speed grades and seeds."""

import json
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

from tqdm import tqdm

from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.parallel import executor
from gravcomp_lab.benches.core import core_run
from gravcomp_lab.shipped import SPHEIRO
from gravcomp_lab.synthesis import place_route
from gravcomp_lab.synthesis.around import registered
from gravcomp_lab.synthesis.place_route import PlacedDesign, place_and_route
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import Netlist, synthesise

TOP = "gc_core"
MULTIPLIER = Path("ecp5/gc_multiply_18_18.v")
# Multipliers and pins of the parts in their packages, the smallest first.
PARTS = {"25k": (28, 197), "45k": (72, 245), "85k": (156, 365)}
TARGETS = ("ecp5", "xilinx", "gowin")
SPEEDS = (6, 8)
SEEDS = (1, 2, 3)
# Above this the path inside a multiplier, which nextpnr does not time, may be the slowest one.
CREDIBLE_MHZ = 250.0


@dataclass(frozen=True)
class LanesResult:
    """One number of lanes: interval and latency in clocks, cells by target, clock and slowest path by speed grade.

    part: one of PARTS. cells["placed"] is what nextpnr counts, with the flip-flops put at the ports; clock_mhz is by
    speed grade and seed.
    """

    lanes: int
    part: str
    interval: int
    latency: int
    port_flip_flops: int
    cells: dict[str, dict[str, int]]
    clock_mhz: dict[int, list[float]]
    slowest_path: dict[int, tuple[str, str]]

    def quoted_mhz(self, speed: int) -> float:
        """The best clock of a speed grade over the seeds, but none that is not credible."""
        return min(max(self.clock_mhz[speed]), CREDIBLE_MHZ)


def survey(
    lanes: Sequence[int], rtl: Path, build: Path, jobs: int, weights: Path = SPHEIRO, backend: str = "threading"
) -> list[LanesResult]:
    """Synthesise, place and route the core of a machine folder for each number of lanes.

    Files go to a folder of its name in build/synth, results also as JSON. Interval and latency are measured in
    simulation. backend: of gravcomp.parallel; a cluster's workers see rtl and build under the same paths. Raises
    InputError when a tool fails, or no part holds the core.
    """
    folder = build / "synth" / weights.name
    sources = machine_sources(rtl, weights, folder)
    simulated = {n: core_run(n, rtl, folder, weights, folder / "generated") for n in lanes}
    timing = {n: (run.interval, run.latency) for n, run in simulated.items()}
    cases = list(product(sorted(lanes, reverse=True), SPEEDS, SEEDS))
    n_runs = 1 + len(lanes) * len(TARGETS) + len(cases)
    with tqdm(total=n_runs, unit="run", desc="nextpnr, once") as bar, executor(backend, jobs) as pool:
        place_route.prepare()
        bar.update()
        todo = product(TARGETS, sorted(lanes, reverse=True))
        mapping = rtl / MULTIPLIER
        netlists = dict(finish(bar, [pool.submit(_netlist, *case, sources, mapping, folder) for case in todo]))
        parts = {n: part_of(netlists["ecp5", n].cells, netlists["ecp5", n].port_bits()) for n in lanes}
        runs = [pool.submit(_place, case, netlists["ecp5", case[0]], parts[case[0]], folder) for case in cases]
        placements = dict(finish(bar, runs))
    results = [_result(n, parts[n], timing[n], netlists, placements) for n in lanes]
    rows = [{**asdict(result), "quoted_mhz": {s: result.quoted_mhz(s) for s in SPEEDS}} for result in results]
    write_atomically(folder / "synth.json", json.dumps(rows, indent=1))
    return results


def machine_sources(rtl: Path, weights: Path, folder: Path) -> list[Path]:
    """The VHDL of rtl with the ROM of a machine folder, which is written to folder/generated."""
    sources = rtl_sources(rtl, folder / "generated")
    write_rom(weights, folder / "generated")
    return sources


def part_of(cells: Mapping[str, int], pins: int) -> str:
    """The smallest part that holds the multipliers and the pins. Raises InputError when there is none."""
    needed = cells.get("MULT18X18D", 0)
    for part, (multipliers, most_pins) in PARTS.items():
        if needed <= multipliers and pins <= most_pins:
            return part
    raise InputError(
        f"{TOP}: {needed} multipliers and {pins} pins, the largest part has {multipliers} and {most_pins}; "
        "take fewer lanes or axes"
    )


def _netlist(
    target: str, lanes: int, sources: Sequence[Path], mapping: Path, folder: Path
) -> tuple[tuple[str, int], Netlist]:
    out = folder / f"{target}-{lanes}"
    verilog = to_verilog(sources, TOP, {"lanes_g": lanes}, out / "core.v")
    placed = {"mapping": mapping, "around": registered} if target == "ecp5" else {}
    return (target, lanes), synthesise(verilog, TOP, target, out, **placed)


def _result(lanes: int, part: str, timing: tuple[int, int], netlists: dict, placements: dict) -> LanesResult:
    runs = {speed: [placements[lanes, speed, seed] for seed in SEEDS] for speed in SPEEDS}
    best = {speed: max(runs[speed], key=lambda run: run.clock.mhz) for speed in SPEEDS}
    cells = {target: netlists[target, lanes].cells for target in TARGETS}
    return LanesResult(
        lanes=lanes,
        part=part,
        interval=timing[0],
        latency=timing[1],
        port_flip_flops=netlists["ecp5", lanes].port_bits() - 1,
        cells={**cells, "placed": best[SPEEDS[0]].used},
        clock_mhz={speed: [run.clock.mhz for run in runs[speed]] for speed in SPEEDS},
        slowest_path={speed: (best[speed].clock.path_from, best[speed].clock.path_to) for speed in SPEEDS},
    )


def _place(
    case: tuple[int, int, int], netlist: Netlist, part: str, folder: Path
) -> tuple[tuple[int, int, int], PlacedDesign]:
    lanes, speed, seed = case
    # Routing is the limit where nine tenths of the largest part's DSP blocks are taken.
    is_full = netlist.cells.get("MULT18X18D", 0) > 0.9 * max(PARTS.values())[0]
    how = {"router": "router2", "options": ["--placer", "static"]} if is_full else {}
    out = folder / f"{lanes}-{speed}-{seed}"
    return case, place_and_route(netlist.json, part=part, speed=speed, seed=seed, out=out, **how)


def finish(bar: tqdm, futures: Iterable) -> Iterable:
    """Results in the order in which they come; the first failure cancels what has not begun."""
    futures = list(futures)
    try:
        for future in as_completed(futures):
            key, value = future.result()
            bar.set_description(" ".join(map(str, key)))
            bar.update()
            yield key, value
    except BaseException:
        for future in futures:
            future.cancel()
        raise
