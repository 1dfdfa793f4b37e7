"""Print initiation interval and latency of the core per number of lanes, as its last simulation measured them."""

import json
from pathlib import Path

from gravcomp.errors import InputError

CLOCK_MHZ = 40.0  # the paper's FPGA


def add_arguments(parser):
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder that the simulation wrote")


def run(arguments):
    rows = [json.loads(path.read_text()) for path in arguments.build.glob("core-3-20-*.json")]
    if not rows:
        raise InputError(f"{arguments.build}: no measurement there; start `make latency`")
    print(f"| lanes | interval, clocks | latency, clocks | latency at {CLOCK_MHZ:.0f} MHz, us | simulated clocks/s |")
    print("|---|---|---|---|---|")
    for row in sorted(rows, key=lambda row: row["lanes"]):
        print(
            f"| {row['lanes']} | {row['interval']} | {row['latency']} | {row['latency'] / CLOCK_MHZ:.3f} "
            f"| {row['simulated_clocks_per_s']} |"
        )
