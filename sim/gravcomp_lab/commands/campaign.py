"""Run campaigns on robots in the physics engine at a core under Verilator: one that is asked for, or ten drawn blind.

Each robot has an effect that its model lacks, drawn by seed and sealed until its campaign has ended. Prints a line per
campaign; with --docs docs/measured/campaign.md is renewed.
"""

from pathlib import Path

from gravcomp.commands.campaign import add_plan, plan_of
from gravcomp.shipped import shipped


def add_arguments(parser):
    parser.add_argument("--machine", default="spheiro", help="shipped machine (default %(default)s)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0], help="one campaign each (default 0)")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build/campaign"), help="folder of library and campaigns")
    parser.add_argument("--docs", type=Path, help="folder of campaign.md (default: only print)")
    add_plan(parser)


def run(arguments):
    from gravcomp_lab.cosim.blind import blind_campaign, tally
    from gravcomp_lab.cosim.library import build, slow_machine
    from gravcomp_lab.pages import renew

    plan = plan_of(arguments)
    folder = slow_machine(shipped(f"weights/{arguments.machine}"), arguments.build / arguments.machine)
    library = build(folder, arguments.rtl, arguments.build / f"{arguments.machine}-core")
    results = []
    for seed in arguments.seeds:
        out = arguments.build / f"{arguments.machine}-{seed}"
        results.append(blind_campaign(library, folder, out, plan, seed))
        print(tally(results[-1:]), flush=True)
        if arguments.docs:
            renew(arguments.docs / "campaign.md", "tally", tally(results))
