"""Print initiation interval and latency of the core per number of lanes, as its last simulation measured them."""

import json
from pathlib import Path

from gravcomp.errors import InputError

CLOCK_MHZ = 40.0  # the paper's FPGA
COLUMNS = ("lanes", "interval", "latency", "simulated_clocks_per_s")


def add_arguments(parser):
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder that the simulation wrote")


def run(arguments):
    try:
        rows = [json.loads(path.read_text()) for path in arguments.build.glob("core-3-20-*.json")]
        measured = sorted([row[name] for name in COLUMNS] for row in rows)
    except (OSError, ValueError, KeyError, TypeError):
        measured = []
    if not measured:
        raise InputError(f"{arguments.build}: no measurement there, or a damaged one; start `make latency`")
    print(f"| lanes | interval, clocks | latency, clocks | latency at {CLOCK_MHZ:.0f} MHz, us | simulated clocks/s |")
    print("|---|---|---|---|---|")
    for lanes, interval, latency, clocks_per_s in measured:
        print(f"| {lanes} | {interval} | {latency} | {latency / CLOCK_MHZ:.3f} | {clocks_per_s} |")
