"""Blind data of the virtual prototype: effects drawn by seed, a CSV for the diagnosis, the answer in a sealed file.

Cases as in ``blind``, of one to several times the noise. Modes: holds, slow motion, both. A log that exists already
isn't measured again.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.measurement import Measurement
from gravcomp.prototype import DEFAULT_NOISE_N, MODES
from gravcomp.prototype.experiment import measure, write_measurement
from gravcomp.prototype.imperfections import EFFECTS, LISTED, UNLISTED, Effect
from gravcomp_lab.blind.from_model import CASES, ONE_EFFECT
from gravcomp_lab.shipped import shipped_machine

DRAWN = [name for name in LISTED if name != "inertia"]  # slow motion hides it
# Holds don't show it: no speed, or friction that has slid fully, which is Coulomb friction.
NOT_IN_HOLDS = ("viscous_friction", "stribeck_friction", "presliding_hysteresis")
POINTS = {"static": 300, "motion": 800, "both": 700}
_TRIES = 20


@dataclass(frozen=True)
class Answer:
    """What was put into a log: names of the effects, their RMS beyond the statics, N, the effort without noise."""

    names: tuple[str, ...]
    effect_rms_n: float
    effort_n: np.ndarray
    mode: str


def measure_case(folder: Path, kind: str, seed: int) -> Path:
    """Draw and measure one case; returns the CSV's path, the sealed answer lies beside it."""
    path = folder / f"{kind}_{seed}.csv"
    if path.exists() and path.with_suffix(".sealed.json").exists():
        return path
    machine = shipped_machine()
    rng = np.random.default_rng([CASES.index(kind), seed, 7])
    mode = str(rng.choice(MODES))
    for _ in range(_TRIES):
        effects = _draw(kind, mode, rng)
        try:
            log = measure(machine, effects, POINTS[mode], seed, mode=mode)
        except InputError:  # too much for the PID, as it would be for the machine
            continue
        if effects and np.sqrt(np.mean((log.effort_n - machine.robot.forces(log.q_m)) ** 2)) < DEFAULT_NOISE_N:
            continue
        write_measurement(path, log, effects, machine, seed=seed, mode=mode, noise_n=DEFAULT_NOISE_N,
                          effort_n=np.round(log.effort_n, 6).tolist())  # fmt: skip
        return path
    raise InputError(f"{path}: none of {_TRIES} drawn sets of effects could be measured; take another seed")


def read_case(path: Path) -> Measurement:
    """What the diagnosis gets to see."""
    return read_measurement(path, shipped_machine())


def open_seal(path: Path) -> Answer:
    """The answer to a log; only after its diagnosis."""
    content = json.loads(path.with_suffix(".sealed.json").read_text(encoding="utf-8"))
    names = tuple(effect["name"] for effect in content["effects"])
    return Answer(names, content["effect_rms_n"], np.array(content["effort_n"]), content["mode"])


def _draw(kind: str, mode: str, rng: np.random.Generator) -> list[Effect]:
    count = {"listed": 1, "pair": 2, "clean": 0, "unlisted": 1}[kind]
    pool = [name for name in DRAWN if mode != "static" or name not in NOT_IN_HOLDS]
    while True:
        names = rng.choice(UNLISTED if kind == "unlisted" else pool, count, replace=False)
        if not any(len(same.intersection(names)) > 1 for same in ONE_EFFECT):
            return [EFFECTS[str(name)].draw(rng) for name in names]


# What the first driver must be a function of: position, its own or another axis' force, direction, time.
_FOLLOWS = {
    "soft_stop": "q", "friction_bump": "q dir", "current_crosstalk": "f", "magnetic_saturation": "f",
    "periodic_disturbance": "t", "step_change": "t", "universal_joint_friction": "dir", "platform_hose": "q",
}  # fmt: skip


def is_driver(answer: Answer, drivers: list[dict]) -> bool:
    """Is the first driver of the report what the unlisted effect follows?"""
    return bool(drivers) and drivers[0]["variable"].rstrip("0123456789") in _FOLLOWS[answer.names[0]].split()
