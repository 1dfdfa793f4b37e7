"""Measure initiation interval and latency of the core per number of lanes, in simulation, and print them."""

from pathlib import Path

from tqdm import tqdm

from gravcomp_lab.benches.core import LANES, core_run, distinct_lanes

CLOCK_MHZ = 40.0  # the paper's FPGA


def add_arguments(parser):
    parser.add_argument("--lanes", type=int, nargs="+", default=LANES, help="neurons per clock")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="machine folder of its ROM")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of the simulations")


def run(arguments):
    lanes = tqdm(distinct_lanes(arguments.lanes), desc="lanes", delay=2, leave=False, disable=None)
    runs = {n: core_run(n, arguments.rtl, arguments.build, arguments.weights) for n in lanes}
    print(f"| lanes | interval, clocks | latency, clocks | latency at {CLOCK_MHZ:.0f} MHz, us | simulated clocks/s |")
    print("|---|---|---|---|---|")
    for n, found in runs.items():
        us = found.latency / CLOCK_MHZ
        print(f"| {n} | {found.interval} | {found.latency} | {us:.3f} | {found.clocks_per_s:.0f} |")
