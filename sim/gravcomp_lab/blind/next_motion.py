"""Does the planned next measurement leave one name? Poor logs drawn by seed, planned for, measured again, diagnosed.

The machines and effects are those of ``from_model``, Gaussian noise. A log is poor: a few holds at one speed, or a
small part of a motion. Where its diagnosis ends in alternatives that are no identity, ``plan`` asks for one
measurement; it is taken with the same effect and noise, and both logs together are diagnosed.
"""

from dataclasses import dataclass, replace

import numpy as np

from gravcomp.diagnosis.diagnosis import Diagnosis, diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.plan.plan import Plan, Reach, contested, correlated, plan, rivals
from gravcomp.logs.joining import joined
from gravcomp.logs.measurement import Measurement
from gravcomp_lab.blind.from_model import drawable, listed, machine_log

_KEPT = {"holds": (40, 100), "motion": (150, 400), "arm": (100, 300), "slide": (100, 300)}


@dataclass(frozen=True)
class MotionOutcome:
    """alternatives: of the poor log; rest: of both logs together; same: rivals that plan calls inseparable."""

    seed: int
    machine: str
    truth: str
    n_first: int
    alternatives: list[list[str]]
    n_next: int
    evidence: float
    same: tuple
    named: tuple[str, ...]
    rest: list[list[str]]

    @property
    def is_planned(self) -> bool:
        return self.n_next > 0

    @property
    def is_one_name(self) -> bool:
        """Nothing is left that plan did not call inseparable on this machine."""
        pairs = [{*" and ".join(pair).split(" and ")} for pair in self.same]
        return all(any({names[0], other} <= pair for pair in pairs) for names in self.rest for other in names[1:])


class Generator:
    """One machine with one effect, of one to five times the noise: measures whatever rows it is given."""

    def __init__(self, seed: int):
        self.rng = np.random.default_rng([9, seed])
        self.machine = str(self.rng.choice(["holds", "motion", "arm", "slide"]))
        whole = machine_log(self.machine, self.rng)
        self.reach = Reach.of(whole)
        data = _poor(whole, self.machine, self.rng)
        self.truth = str(self.rng.choice(drawable(whole)))
        self.effect = listed(self.truth, whole, self.rng)
        own = self.effect(data)
        self.sigma = self.rng.uniform(0.2, 1.0) * (0.1 if data.unit == "Nm" else 1.0)
        rms = np.sqrt(np.mean(own**2))
        self.size = float(self.rng.uniform(1.0, 5.0)) * self.sigma / rms if rms else 0.0
        self.log = self._with_noise(data, own)

    def measure(self, rows: Measurement) -> Measurement:
        """Both logs: the rows are measured after the first log, by the machine as that left it."""
        both = joined(self.log, rows)
        own = self.effect(both)[len(self.log.t_s) :]
        return joined(self.log, self._with_noise(rows, own))

    def _with_noise(self, data: Measurement, own: np.ndarray) -> Measurement:
        noise = self.sigma * self.rng.standard_normal(data.shape)
        return replace(data, force=data.nominal + self.size * own + noise)


def run(seed: int) -> MotionOutcome | None:
    """One set; None where its log leaves one name, or none."""
    source = Generator(seed)
    first = diagnose(source.log, Model(), 0)
    open_sets = contested(first)
    if not open_sets or not source.size:
        return None
    found = next_measurement(first, open_sets, source.reach)
    named, rest, n_next = _names(first), open_sets, 0
    if found.rows is not None:
        both = diagnose(source.measure(found.rows), Model(), 0)
        named, rest, n_next = _names(both), contested(both), len(found.rows.t_s)
    return MotionOutcome(seed, source.machine, source.truth, len(source.log.t_s), open_sets, n_next, found.evidence,
                   found.same, named, rest)  # fmt: skip


def next_measurement(d: Diagnosis, open_sets: list[list[str]], reach: Reach) -> Plan:
    effects = [(entry.name, entry.parameters) for entry in d.fit.effects]
    noise = correlated(d.noise.sigma, d.after)
    return plan(d.data, rivals(d.data, d.before, effects, open_sets, noise), noise, reach)


def _names(d: Diagnosis) -> tuple[str, ...]:
    return tuple(sorted(entry.name for entry in d.fit.effects))


def _poor(data: Measurement, machine: str, rng) -> Measurement:
    """The first rows only; of holds one speed of approach."""
    n = int(rng.integers(*_KEPT[machine]))
    rows = slice(0, min(n, len(data.t_s)))
    v = data.v[rows]
    if machine == "holds":
        v = np.sign(v) * np.median(np.abs(data.v))
    temp_c = None if data.temp_c is None else data.temp_c[rows]
    return replace(data, t_s=data.t_s[rows], q=data.q[rows], v=v, force=data.force[rows], nominal=data.nominal[rows],
                   temp_c=temp_c)  # fmt: skip


def markdown(outcomes: list[MotionOutcome], first_seed: int, n_drawn: int) -> str:
    """The page: how many sets end in one name, and every set that got a plan."""
    planned = [o for o in outcomes if o.is_planned]
    rows = [
        ("one name is left, beside those that the plan called inseparable", [o.is_one_name for o in planned], ">= 95"),
        ("no alternative at all is left", [not o.rest for o in planned], "-"),
        ("the name that is left is that of the effect", [o.truth in o.named for o in planned], "-"),
        ("logs with alternatives that get a plan", [o.is_planned for o in outcomes], "-"),
    ]
    table = [f"| {what} | {100.0 * np.mean(own):.1f} | {target} | {len(own)} |" for what, own, target in rows]
    command = f"`gravcomp-lab next-motion --sets {len(planned)} --first-seed {first_seed}`, {n_drawn} seeds"
    return _PAGE.format(command=command, table="\n".join(table), sets="\n".join(map(_row, planned)))


def _row(o: MotionOutcome) -> str:
    sets = "; ".join(", ".join(names) for names in o.alternatives)
    kind = "holds" if o.machine == "holds" else "rows of motion"
    rest = f" (or {'; '.join(', '.join(names[1:]) for names in o.rest)})" if o.rest else ""
    return (f"| {o.seed} | {o.machine} | {o.n_first} | {o.truth} | {sets} | {o.n_next} {kind} "
            f"| {', '.join(o.named)}{rest} |")  # fmt: skip


_PAGE = """# One more measurement

{command}; by default the first seed is the hash of the commit that is measured.

Poor logs of one effect, of 1 to 5 times a Gaussian noise: 40 to 100 holds of the built-in robot at one speed of
approach, or the first part of a motion of the robot, of a rotary arm, of a linear axis. Where the diagnosis ends in
alternatives that are no identity, [`gravcomp plan`](../guide/plan.md) asks for one measurement within the machine's
ranges and speeds; it is taken with the same effect and noise, and both logs are diagnosed together.

| | measured % | target % | sets |
|---|---|---|---|
{table}

Logs without a plan hold rivals that are one force on that machine (a thrust constant and an offset where the model is
constant, a payload and a thrust constant on an arm of one mass), or that differ too little in a motion of 1920 rows;
`gravcomp plan` says so, and what else to do.

| seed | machine | rows | effect | the log cannot tell apart | next | left |
|---|---|---|---|---|---|---|
{sets}
"""
