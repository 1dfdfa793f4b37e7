"""The virtual prototype as an experiment: static holds and slow motion under a PID, logged with noise.

Static hold: the PID brings the robot to a pose along its last millimetres, creeps and stops; then position and current
are taken. Static friction keeps the force of the approach, so the signed velocity of its end is logged with the hold.
The travel between poses is skipped: the robot is put, in equilibrium, at the start of each approach.
Slow motion: a smooth path through the workspace, there and back, so every pose is passed in both directions.
What the physics has and the analytic model lacks is a list of effects (``experiment_effects``).
"""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically
from gravcomp.prototype import DEFAULT_NOISE_N, MODES
from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.prototype.imperfections import Imperfection
from gravcomp.prototype.plant import MakeImperfections, Plant
from gravcomp.prototype.travel import Path as Way
from gravcomp.prototype.travel import travel_of
from gravcomp.robot.machine import Machine

_WINDOW_STEPS = 20  # the current is averaged over so long
# An approach turns the platform at this rate, slows down to a creep, and stops; how fast that moves the axes is told by
# Travel.rates.
_APPROACH_RAD_PER_S, _CREEP_RAD_PER_S = 0.008, 0.002
_CRUISE_STEPS, _SLOWING_STEPS, _CREEP_STEPS, _REST_STEPS = 20, 100, 80, 60
_HOLD_PERIOD_S = 2.0  # in the log: the travel takes time, though it isn't simulated
_SAMPLE_STEPS = 200  # of the motion
_PHASE_PER_SAMPLE_RAD = 0.005  # of the path's oscillations: 10 mm/s at most, so that inertia stays below 0.02 N


@dataclass(frozen=True)
class PrototypeLog:
    """What was measured at n samples of k axes.

    t_s (n,); q (n, k), m or rad, as read; v (n, k) signed velocity, of a hold that of its approach; current_a (n, k);
    temperature_c (n,). Not for the CSV: effort (n, k), N or N m, the current without noise; effects that were in it;
    noise (k,) of the efforts, RMS.
    """

    t_s: np.ndarray
    q: np.ndarray
    v: np.ndarray
    current_a: np.ndarray
    temperature_c: np.ndarray
    effort: np.ndarray
    effects: Sequence[Imperfection] = ()
    noise: np.ndarray | None = None


class Sample(NamedTuple):
    """One row of a log before noise; t_s and temperature_c are numbers, the others (k,)."""

    t_s: float
    q: np.ndarray
    v: np.ndarray
    effort: np.ndarray
    temperature_c: float


def measure(
    machine: Machine,
    effects: Sequence[Imperfection] | MakeImperfections,
    n_points: int,
    seed: int,
    *,
    mode: str = "both",
    noise: float | None = None,
    speed: float = 1.0,
    beside_counts: float = 0.0,
) -> PrototypeLog:
    """Run the experiment; a quarter of the points are holds in mode "both", each approached from a side that moves
    every joint. noise: of the efforts, N or N m RMS; by default 0.1 N of the Sphe.I.Ro., and alike in proportion on
    other machines. speed multiplies that of the motion. beside_counts, of the encoders, moves all targets: with
    less than one that is a repeat, which differs by what the machine itself does not repeat.

    Raises InputError for an unknown mode or a number of points that is too small, PoseError if the path is too wide.
    """
    if mode not in MODES or n_points < 8:
        raise InputError(f"mode {mode!r} with {n_points} points; give one of {', '.join(MODES)} and at least 8 points")
    rng = np.random.default_rng(seed)
    n_static = {"static": n_points, "motion": 0, "both": n_points // 4}[mode]
    targets = machine.robot.workspace(n_static, int(rng.integers(2**31)))
    travel, plant = travel_of(machine), Plant(machine, effects)
    beside = machine.drive.positions(beside_counts)
    with _watched(n_points) as progress:
        samples = hold(plant, targets + beside, travel.rates(targets, rng), progress) if n_static else []
        if n_moving := n_points - n_static:
            way = travel.path(rng, speed * n_moving * _PHASE_PER_SAMPLE_RAD)
            samples += follow(plant, lambda done: way(done) + beside, n_moving, n_static * _HOLD_PERIOD_S, progress)
    sigma = np.full(machine.n_axes, noise) if noise is not None else DEFAULT_NOISE_N * plant.sizes.effort
    return as_log(samples, machine, sigma, rng, plant.effects)


def as_log(
    samples: list[Sample],
    machine: Machine,
    noise: np.ndarray,
    rng: np.random.Generator,
    effects: Sequence[Imperfection] = (),
) -> PrototypeLog:
    """Samples as drives with noise (k,), N or N m RMS, report them. Raises InputError where that is no number."""
    t, q, v, effort, temperature = (np.array(column) for column in zip(*samples, strict=True))
    current = (effort + noise * rng.standard_normal(effort.shape)) / machine.drive.effort_per_ampere
    if not np.isfinite(current).all():
        raise InputError("the drives would report currents beyond all numbers; make the effects smaller")
    return PrototypeLog(t, q, v, current, temperature, effort, effects, noise)


@contextmanager
def _watched(n_samples: int) -> Iterator[tqdm]:
    """A progress bar; and if the PID loses the robot, check_control says so instead of NumPy."""
    with tqdm(total=n_samples, desc="measuring", delay=2.0, unit="sample") as progress, np.errstate(all="ignore"):
        yield progress


def hold(plant: Plant, targets: np.ndarray, rates: np.ndarray, progress: tqdm) -> list[Sample]:
    """Hold at targets (n, k), m or rad, each approached with speeds rates (n, k), per rad/s of the approach."""
    to_go, samples = _approach_profile(), []
    for number, (target, rate) in enumerate(zip(targets, rates, strict=True)):
        approach = target - to_go[:, None] * rate
        plant.place(approach[0], _APPROACH_RAD_PER_S * rate, number * _HOLD_PERIOD_S)
        for position in approach[:-_CREEP_STEPS]:
            plant.step(position)
        before = plant.reading
        for position in approach[-_CREEP_STEPS:]:
            plant.step(position)
        velocity = (plant.reading - before) / (_CREEP_STEPS * TIME_STEP_S)
        for _ in range(_REST_STEPS):
            plant.step(target)
        samples.append(_sample(plant, np.broadcast_to(target, (_WINDOW_STEPS, len(target))), velocity))
        progress.update()
    return samples


def follow(plant: Plant, way: Way, n_samples: int, t_s: float, progress: tqdm) -> list[Sample]:
    """Move along a path, there and back."""
    samples = []
    for k in range(n_samples):
        targets = way((k + np.arange(_SAMPLE_STEPS) / _SAMPLE_STEPS) / n_samples)
        if k == 0:
            plant.place(targets[0], (targets[-1] - targets[0]) / (_SAMPLE_STEPS * TIME_STEP_S), t_s)
        plant.pass_by(targets[0])
        for target in targets[:-_WINDOW_STEPS]:
            plant.step(target)
        samples.append(_sample(plant, targets[-_WINDOW_STEPS:]))
        progress.update()
    return samples


def _sample(plant: Plant, targets: np.ndarray, velocity: np.ndarray | None = None) -> Sample:
    """Average the effort while the targets are followed; time and position at the window's middle, velocity over it."""
    t_s, readings, efforts = plant.state.t_s + len(targets) * TIME_STEP_S / 2, [plant.reading], []
    for target in targets:
        plant.step(target)
        readings.append(plant.reading)
        efforts.append(plant.effort())
    plant.check_control()
    if velocity is None:
        velocity = (readings[-1] - readings[0]) / (len(targets) * TIME_STEP_S)
    middle = readings[len(readings) // 2 + 1]
    return Sample(t_s, middle, velocity, np.mean(efforts, axis=0), plant.temperature_c())


def _approach_profile() -> np.ndarray:
    """Angle that is left to go, rad, at each step: constant rate, a smooth slowing down, a creep that dies away."""
    x = np.linspace(0.0, 1.0, _SLOWING_STEPS)
    slowing = _CREEP_RAD_PER_S + (_APPROACH_RAD_PER_S - _CREEP_RAD_PER_S) * (1 - x * x * (3 - 2 * x))
    rate = np.concatenate(
        [np.full(_CRUISE_STEPS, _APPROACH_RAD_PER_S), slowing, np.linspace(_CREEP_RAD_PER_S, 0.0, _CREEP_STEPS)]
    )
    return TIME_STEP_S * (rate.sum() - np.cumsum(rate))


_SPEED = {"m": "mps", "rad": "radps"}


def log_csv(log: PrototypeLog, machine: Machine, with_temperature: bool = False) -> str:
    """The log in the measured-data format: t_s, q{i}_m|_rad, v{i}_mps|_radps, i{i}_a and, if asked for, temp_c."""
    units = list(enumerate(machine.position_units, start=1))
    header = ["t_s", *(f"q{i}_{unit}" for i, unit in units), *(f"v{i}_{_SPEED[unit]}" for i, unit in units)]
    header += [f"i{i}_a" for i, _ in units]
    formats = ["%.3f"] + ["%.9g"] * len(units) + ["%.4g"] * len(units) + ["%.6f"] * len(units)
    table = np.column_stack([log.t_s, log.q, log.v, log.current_a])
    if with_temperature:
        header, formats, table = [*header, "temp_c"], [*formats, "%.2f"], np.c_[table, log.temperature_c]
    row_format = ",".join(formats)
    return "\n".join([",".join(header), *(row_format % tuple(row) for row in table)]) + "\n"


def write_measurement(path: Path | str, log: PrototypeLog, machine: Machine, **facts) -> Path:
    """Write the CSV, and beside it the sealed answer, whose path is returned. Raises InputError if it cannot."""
    path = Path(path)
    if not path.name:
        raise InputError(f"{path}: not a file name; give one that ends in .csv")
    sealed = path.with_suffix(".sealed.json")
    if sealed == path:
        raise InputError(f"{path}: that name is the sealed answer's; give one that ends in .csv")
    beyond = log.effort - machine.robot.forces(log.q)
    answer = {
        "effects": [{"name": e.name, "on_list": e.on_list, "params": e.parameters()} for e in log.effects],
        "effect_rms": np.sqrt(np.mean(beyond**2, axis=0)).tolist(),
        "noise": log.noise.tolist(),
        **facts,
    }
    text = log_csv(log, machine, facts.get("temperature", False))
    write_all_atomically({path: text, sealed: json.dumps(answer, indent=2) + "\n"})
    return sealed
