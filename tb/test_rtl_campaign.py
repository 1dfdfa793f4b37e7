"""Campaigns on a robot in the physics engine at the RTL under Verilator: a linear axis, whose model lacks a spring."""

import json
import shutil

import numpy as np
import pytest

from gravcomp.campaign.campaign import Campaign, Plan
from gravcomp.campaign.journal import AFTER, BEFORE
from gravcomp.campaign.route import HOLD
from gravcomp.commands.campaign import conduct
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.moving import load_motion
from gravcomp.errors import InputError
from gravcomp.prototype.imperfections import CableSpring
from gravcomp.robot.machine import load_machine
from gravcomp_lab.cosim.blind import floor, home
from gravcomp_lab.cosim.limits import limits_toml
from gravcomp_lab.cosim.world import World
from support.cosim_core import slide_core

STIFFNESS_N_PER_M, FREE_M = 60.0, 0.21
PLAN = Plan(poses=8, legs=4, seed=4, speed=0.08)  # one leg alone leaves the spring 6 % of its stiffness
INERTIA = {"inertia"}  # which the robot has, and the legs of so short a campaign show

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("verilator"), reason="no Verilator; `scripts/setup.sh verilator` installs it"),
]


class CutWorld(World):
    """Its line is cut after so many exchanges; the robot goes on without a host."""

    exchanges_left = 10**9

    def _exchange(self) -> None:
        if self.exchanges_left <= 0:
            raise InputError(f"{self.line}: no answer any more")
        self.exchanges_left -= 1
        super()._exchange()


@pytest.fixture(scope="module")
def core():
    return slide_core("campaign")


def campaign_of(world: World, folder, out, resume: bool = False) -> Campaign:
    limits = out.with_suffix(".toml")
    limits.write_text(limits_toml(world))
    gains = load_motion(limits, folder)
    return Campaign(Board(world), folder, load_limits(limits, folder), gains, out, PLAN, resume=resume)


def conducted(world: World, campaign: Campaign) -> dict:
    return conduct(campaign, lambda states: home(world, states))


def named(content: dict) -> dict[str, dict]:
    """Parameters by name of what was found."""
    return {effect["name"]: effect["params"] for effect in content["found"]["effects"]}


def held_out(campaign: Campaign) -> np.ndarray:
    """Counts (n, k) of the held-out poses."""
    return np.array([step.pose for step in campaign.steps if step.is_held_out and step.kind == HOLD])


def test_a_campaign_goes_on_after_a_cut_line_and_tells_what_is_missing(core, tmp_path, capsys):
    library, folder = core
    machine, out = load_machine(folder), tmp_path / "out"
    world = CutWorld(library, machine, lambda robot, sizes: [CableSpring(sizes, k=STIFFNESS_N_PER_M, q0=FREE_M)], 1)
    campaign = campaign_of(world, folder, out)
    states = campaign.home()
    home(world, states)
    steps = campaign.before()
    for _ in range(3):
        next(steps)
    world.exchanges_left = 50
    with pytest.raises(InputError, match="no answer any more"):
        list(steps)
    assert world.port.released == 1, "the line alone was cut"
    world.wait(2300)  # the watchdog's time, 2 s, and a bit
    assert (world.port.released, world.port.enabled) == (0, 0)
    assert len(campaign.journal.entries) == 3

    world.exchanges_left, world.engaged = 10**9, 0
    content = conducted(world, campaign_of(world, folder, out, resume=True))
    world.wait(2)  # until the brakes that it has engaged have fallen
    assert world.engaged == 2  # before it diagnoses and at the end, by the campaign itself
    assert content == json.loads((out / "campaign.json").read_text())
    lines = [json.loads(line) for line in (out / "journal.jsonl").read_text().splitlines()]
    assert [line["step"] for line in lines if line["phase"] == BEFORE] == list(range(PLAN.poses + PLAN.legs))
    assert [line["sitting"] for line in lines[:5]] == [0, 0, 0, 1, 1]

    found = named(content)
    assert set(found) - INERTIA == {"cable_spring"}
    assert found["cable_spring"]["k_1"] == pytest.approx(STIFFNESS_N_PER_M, rel=0.05)
    assert content["not_loaded"] is None
    assert f"{campaign.board.host.bank_crc():08x}" == content["loaded"]
    # At rest; in motion there is the inertia of the robot, too, which has no place in the hardware.
    assert content[AFTER]["servo"]["holds"]["rms_n"] < 1.1 * floor(content)
    spring_n = STIFFNESS_N_PER_M * (machine.drive.positions(held_out(campaign)) - FREE_M)
    assert content[BEFORE]["servo"]["holds"]["rms_n"] == pytest.approx(np.sqrt(np.mean(spring_n**2)), rel=0.05)
    assert "report.html" in capsys.readouterr().out
    assert (out / "report.html").read_text().count("<svg") == 1
