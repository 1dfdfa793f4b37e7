"""Campaigns on robots with an effect drawn by seed, sealed until the campaign has ended, and their tally."""

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.campaign.campaign import Campaign, Plan
from gravcomp.commands.campaign import conduct
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.host import State
from gravcomp.driver.moving import load_motion
from gravcomp.files import write_atomically
from gravcomp.prototype.engine import Engine
from gravcomp.prototype.imperfections import Imperfection, drawable, drawn
from gravcomp.prototype.sizes import Sizes
from gravcomp.robot.machine import load_machine
from gravcomp_lab.cosim.limits import limits_toml
from gravcomp_lab.cosim.world import World

EFFECTS = ("payload", "coulomb_friction", "cogging", "cable_spring", "base_tilt", "none")
_HEAD = (
    "seed", "sealed", "found", "loaded", "servo before: at rest, in motion, N", "after", "after over the floor",
    "payload off", "brakes fell", "robot, s", "clocks per second of processor time", "wall time, s",
)  # fmt: skip
_SKEW = 0.25  # of Coulomb friction, between the directions


@dataclass(frozen=True)
class Outcome:
    """A campaign that has ended, and what was sealed: name and parameters. steps: of the robot, ms; engaged: how often
    brakes fell on a robot that was held and was not to be braked.
    """

    seed: int
    truth: str
    params: dict
    report: dict
    steps: int
    engaged: int
    clocks: int
    wall_s: float
    cpu_s: float


def draw(seed: int, engine: Engine, sizes: Sizes) -> list[Imperfection]:
    """One of EFFECTS that the machine can have, of random size."""
    rng = np.random.default_rng([seed, 17])
    name = str(rng.choice([*drawable(EFFECTS[:-1], engine, sizes), EFFECTS[-1]]))
    if name == "none":
        return []
    effect = drawn(name, rng, engine, sizes)
    if name == "coulomb_friction":
        effect.skew = _SKEW * effect.fc * rng.choice([-1.0, 1.0], effect.fc.shape)
    return [effect]


def home(world: World, states: Iterator[State]) -> None:
    """Bring homing to its end: the axes are moved by hand once it is armed."""
    for number, _ in enumerate(states):
        if number == 0:
            world.by_hand()


def blind_campaign(library: Path, folder: Path, out: Path, plan: Plan, seed: int) -> Outcome:
    """One campaign on the machine of a folder with what seed draws; out is resumed if it holds one. Only once it has
    ended is the seal, out/sealed.json, written from what the robot has.
    """
    machine = load_machine(folder)
    world = World(library, machine, lambda engine, sizes: draw(seed, engine, sizes), seed)
    out.mkdir(parents=True, exist_ok=True)
    limits = out / "limits.toml"
    write_atomically(limits, limits_toml(world))
    start, cpu = time.monotonic(), time.process_time()
    with Board(world) as board:
        campaign = Campaign(
            board, folder, load_limits(limits, folder), load_motion(limits, folder), out, plan,
            resume=(out / "plan.json").exists(),
        )  # fmt: skip
        report = conduct(campaign, lambda states: home(world, states))
        world.wait(2)  # until the brakes that it has engaged have fallen
        clocks = world.port.clock
    wall_s, cpu_s = time.monotonic() - start, time.process_time() - cpu
    effects = world.plant.effects
    sealed = {effect.name: effect.parameters() for effect in effects} or {"none": {}}
    write_atomically(out / "sealed.json", json.dumps(sealed, indent=2) + "\n")
    truth, params = next(iter(sealed.items()))
    # The campaign engages them itself whenever it has measured a phase: before it diagnoses, and at the end.
    ordered = len({entry.phase for entry in campaign.journal.entries if entry.sitting == campaign.journal.sitting})
    return Outcome(seed, truth, params, report, world.steps, world.engaged - ordered, clocks, wall_s, cpu_s)


def floor(report: dict) -> float:
    """What no constant can take from the effort of the servo: noise of the currents, and error of the network."""
    return float(np.hypot(report["noise"], report["network"]))


def payload_error(outcome: Outcome) -> float | None:
    """How far the first moment found is off that of the payload, in parts of it; None where none was found."""
    if outcome.truth != "payload":
        return None
    true = outcome.params["m"] * np.array([outcome.params[axis] for axis in "xyz"])
    for effect in outcome.report["found"]["effects"]:
        if effect["name"] == "payload":
            found = np.array([effect["params"][f"moment_{axis}"] for axis in "xyz"])
            return float(np.linalg.norm(found - true) / np.linalg.norm(true))
    return None


def tally(outcomes: Sequence[Outcome]) -> str:
    """A table, a row per campaign."""
    lines = [f"| {' | '.join(_HEAD)} |", "|" + "---|" * len(_HEAD)]
    lines += [f"| {' | '.join(_cells(outcome))} |" for outcome in outcomes]
    return "\n".join(lines)


def _cells(o: Outcome) -> list[str]:
    r, last = o.report, o.report.get("after", o.report["before"])
    names = ", ".join(effect["name"] for effect in r["found"]["effects"]) or "nothing"
    off = payload_error(o)
    pairs = [[e["servo"][part]["rms_n"] for part in ("holds", "motion")] for e in (r["before"], last)]
    over = [value / floor(r) for value in pairs[1]]
    return [
        str(o.seed), o.truth, names, "yes" if r["loaded"] else "no",
        "{:.3f}, {:.3f}".format(*pairs[0]), "{:.3f}, {:.3f}".format(*pairs[1]) if "after" in r else "as before",
        "{:.2f}, {:.2f}".format(*over), "" if off is None else f"{100 * off:.1f} %", str(o.engaged),
        f"{o.steps / 1000:.0f}", f"{o.clocks / o.cpu_s:.0f}", f"{o.wall_s:.0f}",
    ]  # fmt: skip
