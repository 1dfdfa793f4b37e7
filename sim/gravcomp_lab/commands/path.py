"""Measure the path through gc_system in simulation, from an edge on an encoder pin to the command, and print it."""

from pathlib import Path

from gravcomp_lab.benches.core import distinct_lanes
from gravcomp_lab.benches.system import path_run

CLOCKS_PER_US = 40
CONTROL_PERIOD_US = 100  # of a control loop at 10 kHz


def add_arguments(parser):
    parser.add_argument("--lanes", type=int, default=4, help="neurons per clock (default 4)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="machine folder of its ROM")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of the simulation")


def run(arguments):
    (lanes,) = distinct_lanes([arguments.lanes])
    path = path_run(lanes, arguments.rtl, arguments.build, arguments.weights)
    us, worst = path.shortest / CLOCKS_PER_US, path.shortest + CONTROL_PERIOD_US * CLOCKS_PER_US - 1
    print(
        f"{path.to_count} clocks from edge to count, {path.to_current} from tick to current, "
        f"{path.to_command} through the limits"
    )
    print(f"{len(path.clocks)} edges: {path.shortest} to {path.clocks.max()} clocks with a tick of {path.tick_clocks}")
    print(f"path {path.shortest} clocks, {us:.3f} us at 40 MHz, {us / CONTROL_PERIOD_US:.2%} of {CONTROL_PERIOD_US} us")
    print(f"with a tick of 10 kHz at most {worst} clocks, {worst / CLOCKS_PER_US:.2f} us")
