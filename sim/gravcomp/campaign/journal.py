"""What a campaign has measured, kept step by step: a line of JSON each, so that what is there is whole."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.logs.records import Records, measured_csv, records_of
from gravcomp.robot.machine import Machine

BEFORE, BETWEEN, AFTER = "before", "between", "after"
_PAUSE_TICKS = 1000  # between two sittings, of which nobody knows how far they are apart


@dataclass(frozen=True)
class Entry:
    """One step that was measured. sitting: of the campaign, from 0 on; step: of its route.

    words: records as they came; velocity: of each per axis, m/s or rad/s: of a hold that of its approach.
    """

    phase: str
    step: int
    sitting: int
    words: list[list[int]]
    velocity: list[list[float]]


class Journal:
    """The entries of a file, the oldest first. Raises InputError for a line that is none."""

    def __init__(self, path: Path):
        self._path = path
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True) if path.exists() else []
        self.entries = [_entry(path, number, line) for number, line in enumerate(lines, 1) if line.endswith("\n")]
        if len(self.entries) < len(lines):  # the last one was cut off
            write_atomically(path, "".join(map(_line, self.entries)))
        self.sitting = 1 + max((entry.sitting for entry in self.entries), default=-1)

    def add(self, phase: str, step: int, words: list[list[int]], velocity: np.ndarray) -> None:
        entry = Entry(phase, step, self.sitting, words, velocity.tolist())
        with self._path.open("a", encoding="utf-8") as file:
            file.write(_line(entry))
        self.entries.append(entry)

    def done(self, phase: str) -> set[int]:
        """Steps of a phase that are measured."""
        return {entry.step for entry in self.entries if entry.phase == phase}

    def of(self, phase: str, steps: Iterable[int]) -> list[Entry]:
        """Entries of a phase and some steps."""
        wanted = set(steps)
        return [entry for entry in self.entries if entry.phase == phase and entry.step in wanted]


def _entry(path: Path, number: int, line: str) -> Entry:
    try:
        return Entry(**json.loads(line))
    except (ValueError, TypeError):
        raise InputError(f"{path}, line {number}: is no step of a campaign; delete it, it is measured again") from None


def _line(entry: Entry) -> str:
    return json.dumps(asdict(entry)) + "\n"


def joined(entries: list[Entry], n_axes: int) -> tuple[Records, np.ndarray]:
    """Records of entries one after the other, and their velocities (k, n); ticks go on from sitting to sitting."""
    records = records_of([word for entry in entries for record in entry.words for word in record], n_axes)
    sittings = np.concatenate([np.full(len(entry.words), entry.sitting) for entry in entries])
    steps = np.diff(records.tick, prepend=records.tick[0])
    steps[np.flatnonzero(np.diff(sittings)) + 1] = _PAUSE_TICKS
    return replace(records, tick=np.cumsum(steps)), np.concatenate([entry.velocity for entry in entries])


def measured(entries: list[Entry], machine: Machine, tick_s: float) -> str:
    """The measured CSV of entries."""
    records, velocity = joined(entries, machine.n_axes)
    return measured_csv(records, machine, tick_s, approach=velocity)
