"""The loop closes by itself: measure a machine over its core, find what its model lacks, load it, measure again.

For a core that moves (motion_g) behind a serial port. Homes by hand where an axis has not passed its index, holds poses
spread over the workspace, each approached from both sides, and moves slowly there and back, all under the core's servo;
its recorder measures. Where the diagnosis ends in alternatives, the measurement that tells them apart comes in between.
What it finds, and the hardware can hold, is loaded while the robot is held, and the held-out poses and motions are
measured again. Ends with a table, campaign.json and report.html in the folder of --out. Whatever stops it, the brakes
are engaged and what was measured is kept: --resume goes on.
"""

import contextlib
import sys
from pathlib import Path

from gravcomp.commands.board import add_line, line_of
from gravcomp.commands.diagnose import seed
from gravcomp.errors import InputError


def add_arguments(parser):
    parser.add_argument("port", help="serial device, COM port, or URL of pyserial")
    parser.add_argument("--robot", type=Path, required=True, help="machine folder that the core was built with")
    parser.add_argument("--limits", type=Path, required=True, help="TOML file of limits and gains, as for board move")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the campaign")
    parser.add_argument("--resume", action="store_true", help="go on with the campaign in that folder")
    parser.add_argument("--orientations", type=Path, metavar="CSV",
                        help="poses to hold instead of drawn ones, where the robot takes orientations: "
                        "elevation_deg,azimuth_deg,torsion_deg of the Sphe.I.Ro.")  # fmt: skip
    add_plan(parser)
    add_line(parser)


def add_plan(parser) -> None:
    """The arguments that say what is measured."""
    parser.add_argument("--poses", type=int, default=60, help="to hold (default %(default)s)")
    parser.add_argument("--legs", type=int, default=8, help="of slow motion, there and back (default %(default)s)")
    parser.add_argument("--speed", type=float, default=0.025, metavar="PER_S",
                        help="of the slow motion, ranges of an axis per second (default %(default)s)")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, help="draws poses and legs (default 0)")


def plan_of(arguments):
    """The Plan of the arguments of add_plan. Raises InputError for a speed that cannot be."""
    from gravcomp.campaign.campaign import Plan

    if not 1e-4 <= arguments.speed <= 1:
        raise InputError(f"--speed {arguments.speed:g}: need 0.0001 to 1 ranges per second")
    return Plan(arguments.poses, arguments.legs, arguments.seed, arguments.speed)


def _at_orientations(plan, arguments):
    """The plan, with the poses of a file instead of drawn ones if there is one. Raises InputError."""
    from dataclasses import replace

    from gravcomp.robot.machine import load_machine
    from gravcomp.robot.orientation import read_orientations

    if arguments.orientations is None:
        return plan
    angles = read_orientations(arguments.orientations, load_machine(arguments.robot)).tolist()
    return replace(plan, poses=len(angles), orientations=tuple(map(tuple, angles)))


def run(arguments):
    from gravcomp.campaign.campaign import Campaign
    from gravcomp.driver.board import Board, load_limits
    from gravcomp.driver.interrupts import interrupts
    from gravcomp.driver.moving import load_motion

    plan, line = _at_orientations(plan_of(arguments), arguments), line_of(arguments)
    limits = load_limits(arguments.limits, arguments.robot)
    gains = load_motion(arguments.limits, arguments.robot)
    is_interrupted = None

    def check(state) -> None:
        if is_interrupted():
            raise KeyboardInterrupt

    @contextlib.contextmanager
    def on_the_line():
        nonlocal is_interrupted
        with interrupts() as is_interrupted:
            yield

    with Board(line) as board:
        campaign = Campaign(
            board, arguments.robot, limits, gains, arguments.out, plan, resume=arguments.resume, check=check
        )
        conduct(campaign, _home, on_the_line)


def _home(states) -> None:
    for number, _ in enumerate(states):
        if number == 0:
            print("move every axis over its index by hand, until this goes on by itself", flush=True)


def conduct(campaign, home, on_the_line=contextlib.nullcontext) -> dict:
    """Run a campaign to its end and print its result, which is returned. home brings the states of its homing to their
    end; the line is used within on_the_line. Raises InputError and KeyboardInterrupt, saying what was kept.
    """
    from gravcomp.campaign.report import text

    try:
        found = _measure(campaign, home, on_the_line)
    except InputError as stop:
        raise InputError("; ".join([str(stop), *_kept(campaign)])) from None
    except KeyboardInterrupt:
        print(*_kept(campaign), file=sys.stderr)
        raise
    content = campaign.finish(found)
    print(text(content))
    print(f"{campaign.out / 'report.html'}")
    return content


def _measure(campaign, home, on_the_line) -> dict:
    """What was found; measured before, and again if something was loaded."""
    from tqdm import tqdm

    with tqdm(total=campaign.steps_left(), unit="step", desc="measure", disable=None) as bar:
        with on_the_line():
            home(campaign.home())
            for _ in campaign.before():
                bar.update()
        bar.set_description("diagnose")
        found = campaign.find()
        if more := campaign.plan_between(found):
            bar.set_description("tell apart")
            bar.total = bar.n + more + len(campaign.held_out)
            with on_the_line():
                for _ in campaign.between():
                    bar.update()
            bar.set_description("diagnose")
            found = campaign.find()
        bar.set_description("measure again")
        if found["loads"]:
            with on_the_line():
                for _ in campaign.after():
                    bar.update()
    return found


def _kept(campaign) -> list[str]:
    kept = len(campaign.journal.entries)
    return [f"{kept} measured steps are kept in {campaign.out}, go on with --resume"] if kept else []
