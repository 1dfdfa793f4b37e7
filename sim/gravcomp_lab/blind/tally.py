"""Blind tally: data sets drawn by seed, each diagnosed, then its answer opened and counted."""

import hashlib
import io
import json
import warnings
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import gravcomp
import gravcomp_lab
from gravcomp.diagnosis.diagnosis import Diagnosis, diagnose
from gravcomp.diagnosis.effects import NAMES
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report.report import report
from gravcomp.files import write_atomically
from gravcomp.parallel import run_parallel
from gravcomp.prototype.imperfections import UNLISTED
from gravcomp_lab.blind import from_model, from_prototype

AFTER_LIMIT = 1.05  # after-error over the noise of the same held-out samples
ARMS = ("arm2", "ur5")  # machines whose prototypes are measured beside the Sphe.I.Ro.'s
SOURCES = ("model", "prototype", *ARMS)


@dataclass(frozen=True)
class OpenedSet:
    """One blind set after the seal was opened.

    after_ratio is the after-error over the injected noise as it was drawn on these rows, held out; decided_ratio the
    same where the logged velocity tells the direction; repeat_ratio that over the noise and what the machine itself
    does not repeat.
    """

    source: str
    kind: str
    seed: int
    truth: tuple[str, ...]
    machine: str
    n_samples: int
    ratio: float
    named: tuple[str, ...]
    listed: tuple[str, ...]
    verdict: str
    driver: str
    is_driver_right: bool
    after_ratio: float
    decided_ratio: float
    repeat_ratio: float

    @property
    def is_right(self) -> bool:
        """Listed, pair: each is named or in a set that cannot be told apart. Clean: nothing. Unlisted: driver right."""
        if self.kind in ("listed", "pair"):
            return set(self.truth) <= {*self.named, *self.listed}
        return not self.named if self.kind == "clean" else self.is_driver_right

    @property
    def has_wrong_name(self) -> bool:
        """Named something that isn't in the data."""
        return not set(self.named) <= set(self.truth)


def run_model_case(kind: str, seed: int) -> OpenedSet:
    """Draw from the analytic model, diagnose, open."""
    case = from_model.draw(kind, seed)
    found, content = _diagnose(case.data)
    is_right = kind == "unlisted" and from_model.is_driver(case, content["drivers"])
    return _outcome("model", kind, seed, case.truth, case.machine, case.ratio, found, content, case.noise, is_right,
                    0.0 * case.noise)  # fmt: skip


def run_prototype_case(folder: Path, kind: str, seed: int, machine: str = "spheiro") -> OpenedSet:
    """Measure the virtual prototype of a shipped machine, diagnose the CSV, open the sealed file."""
    path = from_prototype.measure_case(folder, kind, seed, machine)
    found, content = _diagnose(from_prototype.read_case(path, machine))
    answer = from_prototype.open_seal(path)
    noise = found.data.force - answer.effort
    is_right = kind == "unlisted" and from_prototype.is_driver(answer, content["drivers"])
    source = machine if machine in ARMS else "prototype"
    return _outcome(source, kind, seed, answer.names, answer.mode, answer.size, found, content, noise, is_right,
                    answer.unrepeated)  # fmt: skip


def _diagnose(data) -> tuple[Diagnosis, dict]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = diagnose(data, Model(), 0)
    return found, report(found)


def _outcome(
    source, kind, seed, truth, machine, ratio, found: Diagnosis, content, noise, is_driver_right, unrepeated
) -> OpenedSet:
    drivers, decided = content["drivers"], ~found.data.is_undecided[found.is_test]
    after, noise, unrepeated = (own[found.is_test] for own in (found.after, noise, unrepeated))
    return OpenedSet(
        source, kind, seed, truth, machine, len(found.data.t_s), ratio,
        tuple(effect["name"] for effect in content["effects"]),
        tuple(name for names in content["alternatives"] for name in names),
        content["verdict"], drivers[0]["variable"] if drivers else "", is_driver_right,
        _rms(after) / _rms(noise), _rms(after[decided]) / _rms(noise[decided]),
        _rms(after[decided]) / np.hypot(_rms(noise[decided]), _rms(unrepeated[decided])),
    )  # fmt: skip


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))


@dataclass(frozen=True)
class Task:
    """One set to draw, diagnose and open."""

    source: str
    kind: str
    seed: int

    def run(self, logs: Path) -> OpenedSet:
        if self.source == "model":
            return run_model_case(self.kind, self.seed)
        machine = () if self.source == "prototype" else (self.source,)
        return run_prototype_case(logs, self.kind, self.seed, *machine)


class Kept:
    """Outcomes on disk, one file each, so that a tally that was stopped tells what it has and goes on where it was.

    They hold for the code that found them: its digest names their folder.
    """

    def __init__(self, work: Path):
        self.folder = work / f"outcomes_{_digest_of_code()}"

    def path(self, task: Task) -> Path:
        return self.folder / f"{task.source}_{task.kind}_{task.seed}.json"

    def keep(self, task: Task, outcome: OpenedSet) -> None:
        write_atomically(self.path(task), json.dumps(vars(outcome)))

    def read(self, task: Task) -> OpenedSet | None:
        if not self.path(task).is_file():
            return None
        content = json.loads(self.path(task).read_text(encoding="utf-8"))
        return OpenedSet(**{name: tuple(x) if isinstance(x, list) else x for name, x in content.items()})


def _digest_of_code() -> str:
    """Of every module of both packages."""
    files = [file for package in (gravcomp, gravcomp_lab) for file in Path(package.__file__).parent.rglob("*.py")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()[:12]


def tasks(sets: int, prototype_sets: int, arm_sets: int, first_seed: int) -> list[Task]:
    """``sets`` seeds of each kind from the model, ``prototype_sets`` from the prototype of the Sphe.I.Ro., ``arm_sets``
    from that of each of ARMS; in turn, so that a tally that was stopped has some of each.
    """
    sizes = {"model": sets, "prototype": prototype_sets, **dict.fromkeys(ARMS, arm_sets)}
    return [
        Task(source, kind, first_seed + k)
        for k in range(max(sizes.values()))
        for source in SOURCES if k < sizes[source]
        for kind in from_model.CASES
    ]  # fmt: skip


def run_all(todo: list[Task], work: Path, jobs: int, backend: str = "loky") -> list[OpenedSet]:
    """Outcomes of the tasks, of those that are done where Ctrl-C stops it; logs and outcomes stay in ``work``."""
    kept = Kept(work)
    with suppress(KeyboardInterrupt):
        run_parallel(_run, [(task, work, kept) for task in todo if not kept.read(task)], backend, "blind", jobs, 2.0)
    return [outcome for outcome in map(kept.read, todo) if outcome]


def _run(task: Task, work: Path, kept: Kept) -> None:
    kept.keep(task, task.run(work))


def summary(outcomes: list[OpenedSet]) -> list[tuple[str, float, str, int]]:
    """Rows (what, measured %, target, sets)."""
    known, clean, other, pairs = ([o for o in outcomes if o.kind == kind] for kind in from_model.CASES)

    def row(what, flags, target="-"):
        flags = list(flags)
        return what, 100.0 * float(np.mean(flags)) if flags else float("nan"), target, len(flags)

    return [
        row("listed: right effect named or listed", (o.is_right for o in known), ">= 95"),
        row("listed: right effect named itself", (set(o.truth) <= set(o.named) for o in known)),
        row("listed: a name that is not in the data", (o.has_wrong_name for o in known)),
        row(f"listed: after-error <= {AFTER_LIMIT} x noise", (o.after_ratio <= AFTER_LIMIT for o in known)),
        row("listed: the same where the direction is known", (o.decided_ratio <= AFTER_LIMIT for o in known)),
        row("listed: and over the noise with what a repeat differs by", (o.repeat_ratio <= AFTER_LIMIT for o in known)),
        row("clean: no effect named", (o.is_right for o in clean), ">= 97"),
        row("unlisted: right driver first", (o.is_right for o in other), ">= 90"),
        row("unlisted: physical name given", (bool(o.named) for o in other), "<= 5"),
        row("pair: both named or listed", (o.is_right for o in pairs)),
        row("pair: one at least named", (bool(set(o.truth) & set(o.named)) for o in pairs)),
        row("pair: a name that is not in the data", (o.has_wrong_name for o in pairs)),
    ]


def median_and_top(outcomes: list[OpenedSet], kind: str) -> tuple[float, float]:
    """Median and 95th percentile of the after-error over the noise where the direction is known; nan without sets."""
    ratios = [o.decided_ratio for o in outcomes if o.kind == kind]
    return (float(np.median(ratios)), float(np.quantile(ratios, 0.95))) if ratios else (np.nan, np.nan)


_TITLES = {"model": "the model", "prototype": "the prototype", "arm2": "the two-axis arm", "ur5": "the UR5"}
_ABOUT = {
    "model": "The analytic model with one effect of 1 to 5 times the noise (listed), two such (pair), none (clean), or "
    "one on no list\n(unlisted), on the built-in robot (120 to 3600 holds or samples of slow motion), a rotary arm and "
    "a linear axis with fm\ncolumns; noise Gaussian, heavy-tailed, unequal by axis, quantised, with outliers, or "
    "correlated in time.",
    "prototype": "The virtual prototype of `gravcomp measure`, 300 holds, 800 samples of slow motion, or 175 holds "
    "and 525 samples;\n"
    "noise 0.1 N; effects at least as large. Friction at a reversal may hold any force up to its level, "
    "and the log can't\n"
    "tell which: the row \"where the direction is known\" leaves those samples out. The noise is that "
    "drawn on the very rows\n"
    "that are judged.\n\n"
    "No two passes of the machine are equal beside it: encoders and servo dither, and friction comes to "
    "rest near its\n"
    "level, not at it. Each log is measured twice, a part of a count apart; the row \"over the noise "
    "with what a repeat\n"
    "differs by\" counts that as noise. The target is for the row above it.",
    "arm2": "The arm of two axes, measured alike; noise 0.2 % of what an axis bears.",
    "ur5": "The UR5, six axes, measured alike.",
}  # fmt: skip


def markdown(outcomes: list[OpenedSet], first_seed: int, command: str, n_asked: int) -> str:
    """docs/measured/blind.md; n_asked: sets that the whole tally has."""
    lines = ["# Blind tally", "", f"`{command}`: seeds from {first_seed} on; the code was tuned on seeds below 200."]
    if len(outcomes) < n_asked:
        lines += ["", f"**Stopped after {len(outcomes)} of {n_asked} sets**; the rates below are of those."]
    for source in SOURCES:
        own = [o for o in outcomes if o.source == source]
        if own:
            lines += ["", f"## Data of {_TITLES[source]}", "", _ABOUT[source], "", *_section(own), "",
                      f"![confusion matrix](figures/blind_{source}.png)"]  # fmt: skip
    lines += [
        "", "## Misses", "",
        "| source | kind | seed | machine | samples | size/noise | truth | named | verdict | driver | after/noise |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
        *[
            f"| {o.source} | {o.kind} | {o.seed} | {o.machine} | {o.n_samples} | {o.ratio:.1f} | "
            f"{', '.join(o.truth) or '-'} | {', '.join(o.named) or '-'} | {o.verdict} | {o.driver or '-'} | "
            f"{o.after_ratio:.2f} |"
            for o in outcomes
            if not o.is_right or (o.kind == "unlisted" and o.named)
        ],
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _section(outcomes: list[OpenedSet]) -> list[str]:
    median, top = median_and_top(outcomes, "listed")
    return [
        "| | measured % | target % | sets |", "|---|---|---|---|",
        *[f"| {what} | {value:.1f} | {target} | {n} |" for what, value, target, n in summary(outcomes)], "",
        f"After-error over the injected noise, held out, listed sets, direction known: median {median:.3f}, "
        f"95th percentile {top:.3f}.",
    ]  # fmt: skip


def confusion_png(outcomes: list[OpenedSet]) -> bytes:
    """Truth by row, first wrong or only name by column; counts. A set of two effects counts in two rows."""
    unlisted = UNLISTED if any(o.source != "model" for o in outcomes) else from_model.UNLISTED
    rows, columns = [*NAMES, *unlisted, "(clean)"], [*NAMES, "(no name)"]
    counts = Counter((truth, _cell(o, truth)) for o in outcomes for truth in o.truth or ("(clean)",))
    grid = np.array([[counts[row, column] for column in columns] for row in rows], dtype=float)
    part = grid / np.maximum(grid.sum(axis=1, keepdims=True), 1.0)
    figure = Figure(figsize=(10.5, 11), layout="constrained")
    panel = figure.subplots()
    panel.imshow(part, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for i, j in np.argwhere(grid > 0):
        panel.text(j, i, f"{int(grid[i, j])}", ha="center", va="center", color="w" if part[i, j] > 0.6 else "k")
    panel.set_xticks(range(len(columns)), columns, rotation=60, ha="right")
    panel.set_yticks(range(len(rows)), rows)
    panel.axhline(len(NAMES) - 0.5, color="k", lw=0.8)
    panel.axhline(len(rows) - 1.5, color="k", lw=0.8)
    panel.set_xlabel("named by the diagnosis")
    panel.set_ylabel("put into the data: listed (alone or in a pair), unlisted, none")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def _cell(o: OpenedSet, truth: str) -> str:
    """The truth if it was named, else the first name that belongs to nothing in the data."""
    if truth in o.named:
        return truth
    return next((name for name in o.named if name not in o.truth), "(no name)")
