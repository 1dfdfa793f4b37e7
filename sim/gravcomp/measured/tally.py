"""Blind tally: draws data sets by seed, diagnoses each, then opens the answer and counts."""

import io
import warnings
from collections import Counter
from dataclasses import dataclass

import joblib
import numpy as np
from matplotlib.figure import Figure

from gravcomp.measured import blind
from gravcomp.measured.diagnosis import diagnose
from gravcomp.measured.effects import NAMES
from gravcomp.measured.model import Model
from gravcomp.measured.report import report

AFTER_LIMIT = 1.05  # after-error over the noise of the same held-out samples


@dataclass(frozen=True)
class Outcome:
    """One blind set after the seal was opened; after_ratio is the after-error over the injected noise, held out."""

    kind: str
    seed: int
    truth: str
    machine: str
    n_samples: int
    ratio: float
    named: tuple[str, ...]
    listed: tuple[str, ...]
    verdict: str
    driver: str
    is_driver_right: bool
    after_ratio: float

    @property
    def is_right(self) -> bool:
        """Listed: the truth is named or in a set that cannot be told apart. Clean: nothing. Unlisted: driver right."""
        if self.kind == "listed":
            return self.truth in self.named or self.truth in self.listed
        return not self.named if self.kind == "clean" else self.is_driver_right


def run_case(kind: str, seed: int) -> Outcome:
    """Draw, diagnose, open."""
    case = blind.draw(kind, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = diagnose(case.data, Model(), 0)
    content = report(found)
    noise = float(np.sqrt(np.mean(case.noise[found.is_test] ** 2)))
    drivers = content["drivers"]
    return Outcome(
        kind, seed, case.truth, case.machine, len(case.data.t_s), case.ratio,
        tuple(effect["name"] for effect in content["effects"]),
        tuple(name for names in content["alternatives"] for name in names),
        content["verdict"], drivers[0]["variable"] if drivers else "",
        kind == "unlisted" and blind.is_driver(case, drivers), content["after"]["rms_n"] / noise,
    )  # fmt: skip


def run_all(sets: int, first_seed: int, jobs: int, watch=lambda items, total: items) -> list[Outcome]:
    """Outcomes of ``sets`` seeds of each kind."""
    tasks = [(kind, seed) for kind in blind.CASES for seed in range(first_seed, first_seed + sets)]
    pool = joblib.Parallel(n_jobs=jobs, return_as="generator")
    return list(watch(pool(joblib.delayed(run_case)(*task) for task in tasks), len(tasks)))


def summary(outcomes: list[Outcome]) -> list[tuple[str, float, str, int]]:
    """Rows (what, measured %, target, sets)."""
    by = {kind: [o for o in outcomes if o.kind == kind] for kind in blind.CASES}
    known, clean, other = (by[kind] for kind in blind.CASES)

    def percent(flags):
        return 100.0 * float(np.mean(list(flags)))

    return [
        ("listed: right effect named or listed", percent(o.is_right for o in known), ">= 95", len(known)),
        ("listed: right effect named itself", percent(o.truth in o.named for o in known), "-", len(known)),
        (f"listed: after-error <= {AFTER_LIMIT} x noise", percent(o.after_ratio <= AFTER_LIMIT for o in known), "-",
         len(known)),
        ("clean: no effect named", percent(o.is_right for o in clean), ">= 97", len(clean)),
        ("unlisted: right driver first", percent(o.is_right for o in other), ">= 90", len(other)),
        ("unlisted: physical name given", percent(bool(o.named) for o in other), "<= 5", len(other)),
    ]  # fmt: skip


def pooled_ratio(outcomes: list[Outcome], kind: str) -> tuple[float, float]:
    """Median and 95th percentile of the after-error over the noise."""
    ratios = [o.after_ratio for o in outcomes if o.kind == kind]
    return float(np.median(ratios)), float(np.quantile(ratios, 0.95))


def markdown(outcomes: list[Outcome], first_seed: int, command: str) -> str:
    """docs/blind.md."""
    sets = sum(o.kind == "listed" for o in outcomes)
    median, top = pooled_ratio(outcomes, "listed")
    lines = [
        "# Blind tally", "",
        f"`{command}`: {sets} seeds of each kind from {first_seed} on; the code was tuned on seeds below 200 only.",
        "Sets: the analytic model, one effect of 1 to 5 times the noise (listed), none (clean), or one on no list "
        "(unlisted), on the",
        "built-in robot (120 to 3600 holds or samples of slow motion), a rotary arm and a linear axis with fm columns; "
        "noise Gaussian,", "heavy-tailed, unequal by axis, quantised, with outliers, or correlated in time.", "",
        "| | measured % | target % | sets |", "|---|---|---|---|",
        *[f"| {what} | {value:.1f} | {target} | {n} |" for what, value, target, n in summary(outcomes)], "",
        f"After-error over the injected noise on the same held-out samples, listed sets: median {median:.3f}, "
        f"95th percentile {top:.3f}.", "",
        "![confusion matrix](figures/blind_confusion.png)", "", "## Misses", "",
        "| kind | seed | machine | samples | size/noise | truth | named | verdict | driver | after/noise |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    lines += [
        f"| {o.kind} | {o.seed} | {o.machine} | {o.n_samples} | {o.ratio:.1f} | {o.truth or '-'} | "
        f"{', '.join(o.named) or '-'} | {o.verdict} | {o.driver or '-'} | {o.after_ratio:.2f} |"
        for o in outcomes
        if not o.is_right or (o.kind == "unlisted" and o.named)
    ]
    return "\n".join(lines) + "\n"


def confusion_png(outcomes: list[Outcome]) -> bytes:
    """Truth by row, first name given by column; counts."""
    rows = [*NAMES, *blind.UNLISTED, "(clean)"]
    columns = [*NAMES, "(no name)"]
    counts = Counter((o.truth or "(clean)", _cell(o)) for o in outcomes)
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
    panel.set_ylabel("put into the data: listed, unlisted, none")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def _cell(o: Outcome) -> str:
    if not o.named:
        return "(no name)"
    return o.truth if o.truth in o.named else o.named[0]
