"""Area and clock of the core per number of lanes: synthesis, then place and route over speed grades and seeds."""

import json
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp_lab.benches.core import core_run
from gravcomp_lab.shipped import SPHEIRO
from gravcomp_lab.synthesis import place_route
from gravcomp_lab.synthesis.place_route import Placement, place_and_route
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import Netlist, synthesise

TOP = "gc_core"
MULTIPLIER = Path("ecp5/gc_multiply_18_18.v")
# The smallest part that holds the multipliers.
PARTS = {1: "25k", 2: "25k", 4: "45k", 5: "45k", 10: "85k", 20: "85k"}
TARGETS = ("ecp5", "xilinx", "gowin")
SPEEDS = (6, 8)
SEEDS = (1, 2, 3)
# Above this the path inside a multiplier, which nextpnr does not time, may be the slowest one.
CREDIBLE_MHZ = 250.0


@dataclass(frozen=True)
class Result:
    """One number of lanes: interval and latency in clocks, cells by target, clock and slowest path by speed grade.

    cells["placed"] is what nextpnr counts, with the flip-flops put at the ports; clock_mhz is by speed grade and seed.
    """

    lanes: int
    interval: int
    latency: int
    port_flip_flops: int
    cells: dict[str, dict[str, int]]
    clock_mhz: dict[int, list[float]]
    slowest_path: dict[int, tuple[str, str]]

    def quoted_mhz(self, speed: int) -> float:
        """The best clock of a speed grade over the seeds, but none that is not credible."""
        return min(max(self.clock_mhz[speed]), CREDIBLE_MHZ)


def survey(lanes: Sequence[int], rtl: Path, build: Path, jobs: int) -> list[Result]:
    """Synthesise, place and route the core for each number of lanes; files go to build/synth, results also as JSON.

    Interval and latency are measured in simulation. Raises InputError when a tool fails.
    """
    simulated = {n: core_run(n, rtl, build, SPHEIRO) for n in lanes}
    timing = {n: (run.interval, run.latency) for n, run in simulated.items()}
    folder = build / "synth"
    cases = list(product(sorted(lanes, reverse=True), SPEEDS, SEEDS))
    n_runs = 1 + len(lanes) * len(TARGETS) + len(cases)
    with tqdm(total=n_runs, unit="run", desc="nextpnr, once") as bar, ThreadPoolExecutor(jobs) as pool:
        place_route.prepare()
        bar.update()
        todo = product(TARGETS, sorted(lanes, reverse=True))
        netlists = dict(_finish(bar, [pool.submit(_netlist, target, n, rtl, folder) for target, n in todo]))
        runs = [pool.submit(_place, case, netlists["ecp5", case[0]].json, folder) for case in cases]
        placements = dict(_finish(bar, runs))
    results = [_result(n, timing[n], netlists, placements) for n in lanes]
    rows = [{**asdict(result), "quoted_mhz": {s: result.quoted_mhz(s) for s in SPEEDS}} for result in results]
    write_atomically(folder / "synth.json", json.dumps(rows, indent=1))
    return results


def _netlist(target: str, lanes: int, rtl: Path, folder: Path) -> tuple[tuple[str, int], Netlist]:
    out = folder / f"{target}-{lanes}"
    verilog = to_verilog(rtl_sources(rtl), TOP, {"lanes_g": lanes}, out / "core.v")
    is_placed = target == "ecp5"
    mapping = rtl / MULTIPLIER if is_placed else None
    return (target, lanes), synthesise(verilog, TOP, target, out, mapping=mapping, registered=is_placed)


def _result(lanes: int, timing: tuple[int, int], netlists: dict, placements: dict) -> Result:
    runs = {speed: [placements[lanes, speed, seed] for seed in SEEDS] for speed in SPEEDS}
    best = {speed: max(runs[speed], key=lambda run: run.clock_mhz) for speed in SPEEDS}
    cells = {target: netlists[target, lanes].cells for target in TARGETS}
    return Result(
        lanes=lanes,
        interval=timing[0],
        latency=timing[1],
        port_flip_flops=netlists["ecp5", lanes].port_bits() - 1,
        cells={**cells, "placed": best[SPEEDS[0]].used},
        clock_mhz={speed: [run.clock_mhz for run in runs[speed]] for speed in SPEEDS},
        slowest_path={speed: (best[speed].path_from, best[speed].path_to) for speed in SPEEDS},
    )


def _place(case: tuple[int, int, int], netlist: Path, folder: Path) -> tuple[tuple[int, int, int], Placement]:
    lanes, speed, seed = case
    # Routing is the limit where nine tenths of the DSP blocks are taken.
    how = {"router": "router2", "options": ["--placer", "static"]} if lanes == 20 else {}
    out = folder / f"{lanes}-{speed}-{seed}"
    return case, place_and_route(netlist, part=PARTS[lanes], speed=speed, seed=seed, out=out, **how)


def _finish(bar: tqdm, futures: Iterable) -> Iterable:
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
