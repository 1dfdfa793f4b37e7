"""Print how long an inference takes on this machine's processor, and its jitter, beside the core's constant latency."""

import os
from pathlib import Path

from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp_lab.pages import renew
from gravcomp_lab.peers import jitter
from gravcomp_lab.peers.design import workspace_positions
from gravcomp_lab.peers.ours import core_rows, core_timings

N_POSES, SEED = 1024, 61


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="weights folder")
    parser.add_argument(
        "--build", type=Path, default=Path("build"), help="folder of gravcomp-lab synth and for programs"
    )
    parser.add_argument("--docs", type=Path, help="folder whose peers.md is to be renewed")


def run(arguments):
    rows, network = core_rows(arguments.build), load_network(arguments.weights)
    q_m = workspace_positions(load_machine(arguments.weights), N_POSES, SEED)
    programs = {
        name: jitter.compile_c(network, q_m, flags, arguments.build / "jitter" / str(number))
        for number, (name, flags) in enumerate(jitter.C_FLAGS.items())
    }
    before = f"{os.cpu_count()} processors, load average before {os.getloadavg()[0]:.1f}"
    timings = jitter.measure(programs, network, q_m, "idle")
    with jitter.load():
        timings += jitter.measure(programs, network, q_m, "loaded")
    text = jitter.table([*timings, *core_timings(rows)])
    text += f"\n\n{before}; {jitter.C_CALLS} calls in C, {jitter.NUMPY_CALLS} in NumPy; poses of seed {SEED}."
    print(text)
    if arguments.docs:
        renew(arguments.docs / "peers.md", "jitter", text)
