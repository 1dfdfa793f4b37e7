"""Measure the cores of the machines that are shipped: error, operations, clocks, cells; docs/measured/machines.md."""

from pathlib import Path

import numpy as np
from tqdm import tqdm

from gravcomp.core.folder import MachineFolder, load_folder
from gravcomp.core.quantised import quantised
from gravcomp.network.weights import HIDDEN_CSV
from gravcomp.twin.network import core
from gravcomp_lab.benches.budget import budget_run
from gravcomp_lab.benches.core import core_run
from gravcomp_lab.pages import renew
from gravcomp_lab.shipped import ROOT
from gravcomp_lab.synthesis.survey import MULTIPLIER, TOP, machine_sources
from gravcomp_lab.synthesis.verilog import to_verilog
from gravcomp_lab.synthesis.yosys import synthesise

LANES = (1, 4)
N_POSES, SEED = 8000, 2  # those that `gravcomp train` tests on
HEADER = (
    "| machine | axes | inputs | neurons | error, % | products, sums | of sines and cosines "
    "| interval, latency, 1 lane | 4 lanes | LUT4 | CCU2C | FF | MULT18X18D | DP16KD |"
)


def add_arguments(parser):
    parser.add_argument("names", nargs="*", help="machines of weights/ (default: all with a network)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build/machines"), help="folder of simulations and netlists")
    parser.add_argument("--docs", type=Path, help="folder whose machines.md is to be renewed")


def run(arguments):
    names = arguments.names or sorted(path.parent.name for path in (ROOT / "weights").glob(f"*/{HIDDEN_CSV}"))
    rows = [_row(ROOT / "weights" / name, arguments.rtl, arguments.build / name) for name in tqdm(names, "machines")]
    text = "\n".join([HEADER, "|" + "---|" * (HEADER.count("|") - 1), *rows])
    print(text)
    if arguments.docs:
        renew(arguments.docs / "machines.md", "machines", text)


def _row(weights: Path, rtl: Path, build: Path) -> str:
    content = load_folder(weights)
    network, machine = content.network, content.machine
    sources, generated = machine_sources(rtl, weights, build), build / "generated"
    runs = [core_run(lanes, rtl, build, weights, generated) for lanes in LANES]
    counted = budget_run(LANES[0], rtl, build, weights, generated)
    budget, apart = (f"{numbers['multiplications']}, {numbers['sums']}" for numbers in counted)
    verilog = to_verilog(sources, TOP, {"lanes_g": LANES[0]}, build / "core.v")
    cells = synthesise(verilog, TOP, "ecp5", build / "ecp5", mapping=rtl / MULTIPLIER).cells
    columns = [
        f"`{weights.name}`",
        machine.n_axes,
        network.hidden_weights.shape[1],
        network.n_hidden,
        f"{error_percent(content, weights):.2g}",
        budget,
        apart if any(counted[1].values()) else "",
        *(f"{found.interval}, {found.latency}" for found in runs),
        *(cells.get(name, 0) for name in ("LUT4", "CCU2C", "TRELLIS_FF", "MULT18X18D", "DP16KD")),
    ]
    return f"| {' | '.join(map(str, columns))} |"


def error_percent(content: MachineFolder, weights: Path) -> float:
    """Error of the fixed-point core from counts, over poses that training has not seen: RMS in % of the RMS effort."""
    drive, robot = content.machine.drive, content.machine.robot
    q = robot.workspace(N_POSES, SEED)
    wanted = 1e3 * robot.forces(q)
    error_mn = core(drive.counts(q), quantised(content.machine, content.network, weights)).force_mn - wanted
    return 100.0 * float(np.sqrt(np.mean(error_mn**2) / np.mean(wanted**2)))
