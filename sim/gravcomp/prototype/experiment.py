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
from gravcomp.prototype.body import TIME_STEP_S
from gravcomp.prototype.imperfections import Effect
from gravcomp.prototype.plant import Plant
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics, jacobian, passive_jacobian
from gravcomp.robot.spheiro.parameters import RobotParameters
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp.robot.spheiro.statics import holding_forces_at
from gravcomp.robot.spheiro.workspace import pose, sample_workspace

_WINDOW_STEPS = 20  # the current is averaged over so long
# An approach turns the platform at this rate, slows down to a creep, and stops; speeds of the motors are d times that.
_APPROACH_RAD_PER_S, _CREEP_RAD_PER_S = 0.008, 0.002
_CRUISE_STEPS, _SLOWING_STEPS, _CREEP_STEPS, _REST_STEPS = 20, 100, 80, 60
_SIDES_TRIED = 40
_HOLD_PERIOD_S = 2.0  # in the log: the travel takes time, though it isn't simulated
_SAMPLE_STEPS = 200  # of the motion
_PHASE_PER_SAMPLE_RAD = 0.005  # of the path's oscillations: 10 mm/s at most, so that inertia stays below 0.02 N
_PATH_FREQUENCIES = (1.0, 1.382, 0.787)
_PATH_FILL = 0.68  # amplitude of each of two tilts, so that both together stay inside the cone


@dataclass(frozen=True)
class Log:
    """What was measured at n samples of three axes.

    t_s (n,); q_m (n, 3) as read; v_mps (n, 3) signed velocity, of a hold that of its approach; current_a (n, 3);
    temperature_c (n,). Not for the CSV: effort_n (n, 3), N, the current without noise.
    """

    t_s: np.ndarray
    q_m: np.ndarray
    v_mps: np.ndarray
    current_a: np.ndarray
    temperature_c: np.ndarray
    effort_n: np.ndarray


class Sample(NamedTuple):
    """One row of a log before noise; t_s and temperature_c are numbers, the others (3,)."""

    t_s: float
    q_m: np.ndarray
    v_mps: np.ndarray
    effort_n: np.ndarray
    temperature_c: float


def measure(
    machine: Machine,
    effects: Sequence[Effect],
    n_points: int,
    seed: int,
    *,
    mode: str = "both",
    noise_n: float = DEFAULT_NOISE_N,
    speed: float = 1.0,
) -> Log:
    """Run the experiment; a quarter of the points are holds in mode "both", each approached from a side that moves
    every joint. speed multiplies that of the motion.

    Raises InputError for an unknown mode or a number of points that is too small, PoseError if the path is too wide.
    """
    if mode not in MODES or n_points < 8:
        raise InputError(f"mode {mode!r} with {n_points} points; give one of {', '.join(MODES)} and at least 8 points")
    rng = np.random.default_rng(seed)
    n_static = {"static": n_points, "motion": 0, "both": n_points // 4}[mode]
    p = spheiro_of(machine)
    poses = sample_workspace(n_static, p, int(rng.integers(2**31)))
    plant = Plant(machine, effects)
    with _watched(n_points) as progress:
        samples = hold_poses(plant, poses, clear_sides(poses, p, rng), progress) if n_static else []
        samples += follow_path(plant, n_points - n_static, rng, speed, n_static * _HOLD_PERIOD_S, progress)
    t, q, v, effort, temperature = (np.array(column) for column in zip(*samples, strict=True))
    current = (effort + noise_n * rng.standard_normal(effort.shape)) / machine.drive.effort_per_ampere
    return Log(t, q, v, current, temperature, effort)


@contextmanager
def _watched(n_samples: int) -> Iterator[tqdm]:
    """A progress bar; and if the PID loses the robot, check_control says so instead of NumPy."""
    with tqdm(total=n_samples, desc="measuring", delay=2.0, unit="sample") as progress, np.errstate(all="ignore"):
        yield progress


def clear_sides(poses: np.ndarray, p: RobotParameters, rng: np.random.Generator) -> np.ndarray:
    """Sides (n, 3), of some random ones each the one that moves the slowest joint fastest: no friction's sign is in
    doubt. A joint's rate counts relative to that of all its kind.
    """
    motors, passive = jacobian(poses, p), passive_jacobian(poses, p)
    joints = np.concatenate([motors, passive @ motors], axis=-2)
    sides = rng.standard_normal((_SIDES_TRIED, len(poses), 3))
    rates = np.abs(np.einsum("nji,sni->snj", joints, sides / np.linalg.norm(sides, axis=-1, keepdims=True)))
    slowest = (rates / np.sqrt(np.mean(rates**2, axis=(0, 1)))).min(axis=-1)
    return sides[slowest.argmax(axis=0), np.arange(len(poses))]


def hold_poses(plant: Plant, poses: np.ndarray, sides: np.ndarray, progress: tqdm) -> list[Sample]:
    """Hold each pose (n, 3, 3), approached by turning about its side: sides (n, 3), rotation vectors of any length."""
    to_go, samples = _approach_profile(), []
    for k, (rotation, side) in enumerate(zip(poses, sides, strict=True)):
        rate = jacobian(rotation, plant.parameters) @ (side / np.linalg.norm(side))
        target = inverse_kinematics(rotation, plant.parameters)
        approach = target - to_go[:, None] * rate
        plant.place(approach[0], _APPROACH_RAD_PER_S * rate, k * _HOLD_PERIOD_S)
        for position in approach[:-_CREEP_STEPS]:
            plant.step(position)
        before = plant.reading_m
        for position in approach[-_CREEP_STEPS:]:
            plant.step(position)
        velocity = (plant.reading_m - before) / (_CREEP_STEPS * TIME_STEP_S)
        for _ in range(_REST_STEPS):
            plant.step(target)
        samples.append(_sample(plant, np.broadcast_to(target, (_WINDOW_STEPS, 3)), velocity))
        progress.update()
    return samples


def follow_path(
    plant: Plant, n_samples: int, rng: np.random.Generator, speed: float, t_s: float, progress: tqdm
) -> list[Sample]:
    """Move along a path, there and back."""
    start_rad = rng.uniform(0.0, 2 * np.pi, 3)
    samples = []
    for k in range(n_samples):
        done = (k + np.arange(_SAMPLE_STEPS) / _SAMPLE_STEPS) / n_samples
        targets = _path(done, speed * n_samples * _PHASE_PER_SAMPLE_RAD, start_rad, plant.parameters)
        if k == 0:
            plant.place(targets[0], (targets[-1] - targets[0]) / (_SAMPLE_STEPS * TIME_STEP_S), t_s)
        plant.state.statics_n = holding_forces_at(targets[0], plant.parameters)
        for target in targets[:-_WINDOW_STEPS]:
            plant.step(target)
        samples.append(_sample(plant, targets[-_WINDOW_STEPS:]))
        progress.update()
    return samples


def _sample(plant: Plant, targets: np.ndarray, velocity: np.ndarray | None = None) -> Sample:
    """Average the effort while the targets are followed; time and position at the window's middle, velocity over it."""
    t_s, readings, efforts = plant.state.t_s + len(targets) * TIME_STEP_S / 2, [plant.reading_m], []
    for target in targets:
        plant.step(target)
        readings.append(plant.reading_m)
        efforts.append(plant.effort_n())
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


def _path(done: np.ndarray, phase_rad: float, start_rad: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Targets (n, 3), m, where parts 0..1 (n,) of the motion are done.

    Two tilts and the torsion oscillate, up to a phase and back to their start.
    """
    phase = phase_rad * (1.0 - np.cos(2 * np.pi * done)) / 2
    tilt_x, tilt_y, torsion = _PATH_FILL * np.sin(np.outer(_PATH_FREQUENCIES, phase) + start_rad[:, None])
    tilt = np.deg2rad(p.tilt_max_deg) * np.hypot(tilt_x, tilt_y)
    return inverse_kinematics(pose(np.arctan2(tilt_y, tilt_x), tilt, np.deg2rad(p.torsion_max_deg) * torsion), p)


def log_csv(log: Log, with_temperature: bool = False) -> str:
    """The log in the measured-data format: t_s, q{i}_m, v{i}_mps, i{i}_a and, if asked for, temp_c."""
    axes = (1, 2, 3)
    header = ["t_s", *(f"q{i}_m" for i in axes), *(f"v{i}_mps" for i in axes), *(f"i{i}_a" for i in axes)]
    formats = ["%.3f"] + ["%.7g"] * 3 + ["%.4g"] * 3 + ["%.6f"] * 3
    table = np.column_stack([log.t_s, log.q_m, log.v_mps, log.current_a])
    if with_temperature:
        header, formats, table = [*header, "temp_c"], [*formats, "%.2f"], np.c_[table, log.temperature_c]
    row_format = ",".join(formats)
    return "\n".join([",".join(header), *(row_format % tuple(row) for row in table)]) + "\n"


def write_measurement(path: Path | str, log: Log, effects: Sequence[Effect], machine: Machine, **facts) -> Path:
    """Write the CSV, and beside it the sealed answer, whose path is returned. Raises InputError if it cannot."""
    path = Path(path)
    if not path.name:
        raise InputError(f"{path}: not a file name; give one that ends in .csv")
    sealed = path.with_suffix(".sealed.json")
    if sealed == path:
        raise InputError(f"{path}: that name is the sealed answer's; give one that ends in .csv")
    effect_n = log.effort_n - machine.robot.forces(log.q_m)
    answer = {
        "effects": [{"name": e.name, "on_list": e.on_list, "params": e.parameters()} for e in effects],
        "effect_rms_n": float(np.sqrt(np.mean(effect_n**2))),
        **facts,
    }
    text = log_csv(log, facts.get("temperature", False))
    write_all_atomically({path: text, sealed: json.dumps(answer, indent=2) + "\n"})
    return sealed
