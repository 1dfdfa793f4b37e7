"""What comes between two diagnoses: steps that tell apart what the first could not, from the plan of a measurement.

A planned hold is approached once, as fast and from the side that the plan says. A planned motion is cut where an axis
turns back; each part is a leg, there and back, in the time that the plan gives it: the servo of the core goes straight
from place to place.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

import numpy as np

from gravcomp.campaign.route import HOLD, LEG, Step
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.plan.plan import plan
from gravcomp.diagnosis.plan.planned import of_report, reach_of, words
from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.machine import Machine

APPROACH_S = 1.0  # of a planned hold, where the range leaves so much way
LEAST_LEG_S = 1.0  # enough records that are not at rest
_TURN = 0.02  # of the range of an axis: what turns back by less goes on
Duration = Callable[[Sequence[int], Sequence[int], float], float]  # seconds of a move that is asked for in so many


def next_steps(machine: Machine, data: Measurement, report: Path, duration: Duration) -> tuple[list[Step], str]:
    """Steps for the alternatives of a report.json of this log, and why these; none where no measurement would help.

    duration: what the core makes of a move between two places, counts, and the seconds asked for.
    """
    data, rivals, noise = of_report(data, Model(machine), report)
    if not rivals:
        return [], "its alternatives are the same on any data"
    found = plan(data, rivals, noise, reach_of(data, None, None, None))
    why = words(found, noise)[0]
    if found.rows is None:
        return [], why
    return (_legs if found.is_motion else _holds)(machine, found.rows, duration), why


def _holds(machine: Machine, rows: Measurement, duration: Duration) -> list[Step]:
    """A hold per row, from where its velocity comes; seconds is what makes that velocity."""
    low, high = _range(machine)
    steps = []
    for pose, v in zip(np.clip(rows.q, low, high), rows.v if rows.v is not None else np.zeros(rows.shape), strict=True):
        room = np.where(v > 0, pose - low, high - pose) / np.where(v != 0, np.abs(v), np.inf)
        seconds = min(APPROACH_S, room.min(where=v != 0, initial=APPROACH_S))
        if seconds <= 0:  # nothing comes from beyond the range
            continue
        start, end = _counts(machine, pose - v * seconds), _counts(machine, pose)
        steps.append(Step(HOLD, len(steps), end, (start,), False, duration(start, end, seconds)))
    return steps


def _legs(machine: Machine, rows: Measurement, duration: Duration) -> list[Step]:
    """The path between its turning points, each way once: a leg goes there and back."""
    low, high = _range(machine)
    q, size = np.clip(rows.q, low, high), high - low
    corners = sorted({0, len(q) - 1, *(row for x in (q / size).T for row in turns(x, _TURN))})
    steps, ways = [], []
    for start, end in pairwise(corners):
        is_return = bool(ways) and (np.abs(q[end] - q[ways[-1]]) <= _TURN * size).all()
        if is_return:  # the leg before goes back by itself
            ways.pop()
            continue
        ways.append(start)
        places = _counts(machine, q[start]), _counts(machine, q[end])
        seconds = max(rows.t_s[end] - rows.t_s[start], LEAST_LEG_S)
        steps.append(Step(LEG, len(steps), places[0], places, False, duration(*places, seconds)))
    return steps


def turns(x: np.ndarray, least: float) -> list[int]:
    """Rows at which x (n,) begins to move and turns back, by more than least each."""
    found, highest, lowest, way = [], 0, 0, 0
    for row, value in enumerate(x):
        highest = row if value > x[highest] else highest
        lowest = row if value < x[lowest] else lowest
        if way >= 0 and x[highest] - value > least:
            found.append(highest)
            way, lowest = -1, row
        elif way <= 0 and value - x[lowest] > least:
            found.append(lowest)
            way, highest = 1, row
    return found


def _range(machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    return tuple(np.array([getattr(axis, end) for axis in machine.axes]) for end in ("low", "high"))


def _counts(machine: Machine, q: np.ndarray) -> tuple[int, ...]:
    return tuple(machine.drive.counts(q).tolist())


def write_next(path: Path, steps: Sequence[Step], why: str) -> None:
    """Keep the steps: a campaign that was stopped goes on along them."""
    write_atomically(path, json.dumps({"why": why, "steps": [asdict(step) for step in steps]}) + "\n")


def read_next(path: Path) -> tuple[list[Step], str]:
    """Steps and why; none where the file is not there. Raises InputError where it is no such file."""
    if not path.exists():
        return [], ""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return [_step(**entry) for entry in content["steps"]], str(content["why"])
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputError(f"{path}: cannot be read ({error}); delete it, it is planned again") from None


def _step(kind: str, number: int, pose, ends, is_held_out: bool, seconds: float) -> Step:
    return Step(kind, number, tuple(pose), tuple(tuple(end) for end in ends), is_held_out, seconds)
