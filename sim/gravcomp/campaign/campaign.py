"""A campaign: measure, diagnose, place, load, measure again. What acts on the robot is the servo of the core alone.

    board = Board(Line("/dev/ttyUSB0"))
    campaign = Campaign(board, Path("weights/mine"), load_limits(...), load_motion(...), Path("out"), Plan())
    for step in campaign.run():
        print(step)

Folder of a campaign: plan.json, what was asked for; journal.jsonl, every record that was taken; before.csv,
held_out.csv, between.csv and after.csv, measured CSVs; next.json, the steps between; diagnosis/ and loop/, as diagnose
and loop write them; campaign.json and report.html.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gravcomp.campaign.between import next_steps, read_next, write_next
from gravcomp.campaign.figures import efforts, figures, noise
from gravcomp.campaign.journal import AFTER, BEFORE, BETWEEN, Journal, measured
from gravcomp.campaign.measuring import Sitting
from gravcomp.campaign.report import report_page
from gravcomp.campaign.route import HOLD, Step, route
from gravcomp.core.folder import folder_hash
from gravcomp.core.image import Image, load_image
from gravcomp.diagnosis.diagnosis import Diagnosis, diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report.folder import write_report
from gravcomp.driver.board import Board
from gravcomp.driver.host import Settings, State
from gravcomp.driver.motion import MotionSettings
from gravcomp.driver.moving import Mover
from gravcomp.errors import InputError
from gravcomp.files import check_folder, write_all_atomically, write_atomically
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.joining import joined
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.loop import close_loop, loop_errors, weights_folder
from gravcomp.robot.machine import Machine, load_machine
from gravcomp.robot.orientation import positions_at

PLAN, NEXT, JOURNAL, RESULT, PAGE = "plan.json", "next.json", "journal.jsonl", "campaign.json", "report.html"
LONGEST_S = 300.0  # of a step between: a limit of zero would take for ever


@dataclass(frozen=True)
class Plan:
    """What is asked for: poses to hold, legs of slow motion, seed of where they are, ranges per second of the slow
    motion of the fastest axis. orientations: deg, of the poses to hold, in this order, instead of drawn ones."""

    poses: int = 60
    legs: int = 8
    seed: int = 0
    speed: float = 0.025
    orientations: tuple[tuple[float, ...], ...] = ()

    def entries(self) -> dict:
        """What a file of JSON holds of it, as it is read back."""
        return {**asdict(self), "orientations": [list(angles) for angles in self.orientations]}


class Campaign:
    """A campaign on a board with gc_motion, in a folder.

    check is called with the state several times a second; what it raises ends the campaign, with the brakes engaged.
    resume: go on with a campaign that was stopped. Raises InputError for a folder that holds one already, or another
    one than is to be resumed, and what Mover and route raise.
    """

    def __init__(
        self,
        board: Board,
        robot: Path,
        limits: Settings,
        gains: MotionSettings,
        out: Path,
        plan: Plan,
        *,
        resume: bool = False,
        check: Callable[[State], None] = lambda state: None,
    ):
        board.check_machine(robot)
        self.board, self.robot, self.limits, self.out, self.plan, self.check = board, robot, limits, out, plan, check
        self.machine: Machine = load_machine(robot)
        self.mover = Mover(board, limits, gains)
        self.steps = route(self.machine, plan.poses, plan.legs, plan.seed, self._given_poses())
        self._claim(resume)
        self.journal = Journal(out / JOURNAL)
        self.between_steps, self.why_between = read_next(out / NEXT)
        self.held_out = {number for number, step in enumerate(self.steps) if step.is_held_out}

    def _given_poses(self) -> np.ndarray | None:
        """m or rad (n, k); None: to be drawn."""
        if not self.plan.orientations:
            return None
        return positions_at(self.machine, np.array(self.plan.orientations), "orientations")

    def _claim(self, resume: bool) -> None:
        """Write the plan into the folder, or see that it is the one that stands there."""
        asked = {**self.plan.entries(), "machine": self.machine.name, "hash": folder_hash(self.robot, self.machine)}
        path = self.out / PLAN
        if not path.exists():
            if resume:
                raise InputError(f"{self.out}: no campaign to resume; leave --resume out")
            check_folder(self.out)
            write_atomically(path, json.dumps(asked, indent=2) + "\n")
            return
        if not resume:
            raise InputError(f"{self.out}: holds a campaign; go on with it by --resume, or give another folder")
        if (known := {"orientations": [], **_read_plan(path)}) != asked:
            other = next(name for name in asked if known.get(name) != asked[name])
            raise InputError(f"{path}: {other} is {known.get(other)}, asked for is {asked[other]}; give what was")

    def steps_left(self) -> int:
        """Steps still to be measured, if something is found."""
        left = set(range(len(self.steps))) - self.journal.done(BEFORE)
        return len(left) + self.between_left() + len(self.held_out - self.journal.done(AFTER))

    def between_left(self) -> int:
        """Steps of the measurement between still to be measured."""
        return len(set(range(len(self.between_steps))) - self.journal.done(BETWEEN))

    def home(self) -> Iterator[State]:
        """Arm homing if an axis is not referenced; the state, again and again, until all are: moved by hand."""
        if self.board.host.read().referenced != self.board.all_axes:
            for state in self.board.home(self.limits):
                self.check(state)
                yield state

    def before(self) -> Iterator[Step]:
        """Measure the whole route; each step when it is."""
        yield from self._sitting().measure(BEFORE, dict(enumerate(self.steps)), lambda: None)

    def find(self) -> dict:
        """Diagnose what was measured, but the steps that are held out; what is to be loaded goes into loop/.

        Returns what was found, as report.json has it, with ``loads``, whether there is something to load, and ``why``
        not.
        """
        self._write_logs()
        model = Model(self.machine)
        found = diagnose(self._log(), model, self.plan.seed)
        grown, content = write_report(found, model, self.out / "diagnosis")
        why = self._place(found, grown)
        return {**content, "loads": not why, "why": why}

    def _log(self) -> Measurement:
        """What was measured, but the steps that are held out; with what came between, once that is whole."""
        first = read_measurement(self.out / "before.csv", self.machine, {})
        if not self.between_steps or self.between_left():
            return first
        return joined(first, read_measurement(self.out / "between.csv", self.machine, {}))

    def plan_between(self, found: dict) -> int:
        """Plan, once in a campaign, what tells the alternatives of what was found apart; the number of steps that it
        still takes. 0: there are none, no measurement would help, or they are measured already.
        """
        if found["alternatives"] and not (self.out / NEXT).exists():
            report = self.out / "diagnosis" / "report.json"
            steps, self.why_between = next_steps(self.machine, self._log(), report, self.mover.duration_s)
            self.between_steps = [step for step in steps if step.seconds < LONGEST_S]
            write_next(self.out / NEXT, self.between_steps, self.why_between)
        return self.between_left()

    def between(self) -> Iterator[Step]:
        """Measure what was planned between; each step when it is. ``find`` takes it in, once all are."""
        yield from self._sitting().measure(BETWEEN, dict(enumerate(self.between_steps)), lambda: None)

    def _place(self, found: Diagnosis, grown: Model) -> str:
        """Close the loop in files; why nothing is to be loaded, if so."""
        holdable = [e.name for e in found.fit.effects if e.term.candidate.hardware != "none"]
        if not holdable and not any(e.term.candidate.is_of_position for e in found.fit.corrections):
            return "nothing was found that the hardware can hold" if found.fit.effects else "nothing is missing"
        folder = self.out / "loop"
        log = {"log": found.data.name}
        try:
            close_loop(found, grown, self.robot, folder, self.plan.seed, f"gravcomp campaign --out {self.out}", log)
            self._image()
        except InputError as error:
            return str(error)
        fixed = loop_errors(folder)["fixed point"]
        return "" if fixed["after"]["rms_n"] < fixed["before"]["rms_n"] else "it would not make the core better"

    def after(self) -> Iterator[Step]:
        """Load what was found while the robot is held, and measure the held-out steps again."""
        image = self._image()

        def swap() -> None:
            if self.board.host.bank_crc() != image.crc32:
                self.board.load(image)

        steps = {number: self.steps[number] for number in sorted(self.held_out)}
        yield from self._sitting().measure(AFTER, steps, swap)

    def _image(self) -> Image:
        """What was found, as it is loaded."""
        return load_image(weights_folder(self.out / "loop", AFTER), self.robot)

    def _sitting(self) -> Sitting:
        ranges = [(axis.high - axis.low) * per for axis, per in
                  zip(self.machine.axes, self.machine.drive.counts_per_unit, strict=True)]  # fmt: skip
        return Sitting(self.mover, self.journal, self.machine, self.plan.speed * min(ranges), self.check)

    def _write_logs(self) -> None:
        known = set(range(len(self.steps))) - self.held_out
        parts = {"before": (BEFORE, known), "held_out": (BEFORE, self.held_out), "after": (AFTER, self.held_out),
                 "between": (BETWEEN, range(len(self.between_steps)))}  # fmt: skip
        logs = {name: self.journal.of(*part) for name, part in parts.items()}
        texts = {self.out / f"{name}.csv": measured(entries, self.machine, self.mover.tick_s)
                 for name, entries in logs.items() if entries}  # fmt: skip
        write_all_atomically(texts)

    def finish(self, found: dict) -> dict:
        """Write the logs, campaign.json and report.html; the content of campaign.json."""
        self._write_logs()
        phases = {phase: efforts(own, self.steps, self.machine)
                  for phase in (BEFORE, AFTER) if (own := self.journal.of(phase, self.held_out))}  # fmt: skip
        every = self.journal.entries
        content = {
            "schema": 1,
            "machine": {"name": self.machine.name, "hash": folder_hash(self.robot, self.machine)},
            "unit": self.machine.effort_unit,
            "plan": self.plan.entries(),
            "poses": sum(step.kind == HOLD for step in self.steps),
            "held_out": len(self.held_out),
            "between": {"steps": len(self.between_steps), "why": self.why_between} if self.why_between else None,
            "noise": noise(every, self.machine),
            "network": self._network_error(),
            "found": {name: found[name] for name in ("found", "verdict", "effects", "alternatives", "drivers", "next")},
            "loaded": f"{self._image().crc32:08x}" if found["loads"] else None,
            "not_loaded": found["why"] or None,
            "sittings": 1 + max(entry.sitting for entry in every),
            **{phase: figures(own) for phase, own in phases.items()},
        }
        files = {RESULT: json.dumps(content, indent=2) + "\n", PAGE: report_page(content, phases, self.machine)}
        write_all_atomically({self.out / name: text for name, text in files.items()})
        return content

    def _network_error(self) -> float:
        """RMS of what the core's feed-forward is off the model that it was trained on, where it was measured."""
        e = efforts(self.journal.of(BEFORE, self.held_out), self.steps, self.machine)
        return float(np.sqrt(np.mean((e.forward - self.machine.robot.forces(e.q)) ** 2)))


def _read_plan(path: Path) -> dict:
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give another folder") from None
    if not isinstance(known, dict):
        raise InputError(f"{path}: is no plan of a campaign; give another folder")
    return known
