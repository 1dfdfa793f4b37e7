"""Blind data of virtual prototypes: effects drawn by seed, a CSV for the diagnosis, the answer in a sealed file.

Cases as in ``blind``, of one to several times the noise. Modes: holds, slow motion, both. A log that exists already
isn't measured again.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.measurement import Measurement
from gravcomp.prototype import MODES
from gravcomp.prototype.engine import Engine
from gravcomp.prototype.experiment import measure, write_measurement
from gravcomp.prototype.imperfections import LISTED, UNLISTED, Imperfection, drawable, drawn
from gravcomp.prototype.sizes import Sizes
from gravcomp_lab.blind.from_model import CASES, ONE_EFFECT
from gravcomp_lab.shipped import shipped_machine

DRAWN = [name for name in LISTED if name != "inertia"]  # slow motion hides it
# Holds don't show it: no speed, or friction that has slid fully, which is Coulomb friction.
NOT_IN_HOLDS = ("viscous_friction", "stribeck_friction", "presliding_hysteresis")
POINTS = {"static": 300, "motion": 800, "both": 700}
_TRIES = 20
_BESIDE = 0.37  # of a count: no simple part of one, so that nothing rounds alike


@dataclass(frozen=True)
class Answer:
    """What was put into a log of n rows and k axes: names of the effects, their RMS beyond the statics in parts of the
    noise, the effort (n, k) without noise, N or N m, and the noise (k,), RMS. unrepeated (n, k): by how much the effort
    without noise is another when the same is measured once more, over sqrt(2): dither of encoder and servo, and where
    within its level a friction comes to rest.
    """

    names: tuple[str, ...]
    size: float
    effort: np.ndarray
    noise: np.ndarray
    mode: str
    unrepeated: np.ndarray


def measure_case(folder: Path, kind: str, seed: int, machine: str = "spheiro") -> Path:
    """Draw and measure one case on a shipped machine; returns the CSV's path, the sealed answer lies beside it."""
    path = folder / (f"{kind}_{seed}.csv" if machine == "spheiro" else f"{machine}_{kind}_{seed}.csv")
    if path.exists() and _is_sealed(path):
        return path
    robot = shipped_machine(machine)
    rng = np.random.default_rng([CASES.index(kind), seed, 7])
    mode = str(rng.choice(MODES))
    for k in range(_TRIES):
        way = seed + (k << 32)  # poses and motion are others, too: those of a seed may be what the PID cannot do
        try:
            log = measure(robot, _draw(kind, mode, rng), POINTS[mode], way, mode=mode)
            again = measure(robot, log.effects, POINTS[mode], way, mode=mode, beside_counts=_BESIDE)
        except InputError:  # too much for the PID, as it would be for the machine
            continue
        beyond, repeated = (own.effort - robot.robot.forces(own.q) for own in (log, again))
        if log.effects and _size(np.sqrt(np.mean(beyond**2, axis=0)), log.noise) < 1.0:
            continue
        rows = {"effort": log.effort, "unrepeated": (beyond - repeated) / np.sqrt(2.0)}
        write_measurement(
            path, log, robot, seed=seed, mode=mode, **{name: np.round(own, 6).tolist() for name, own in rows.items()}
        )
        return path
    raise InputError(f"{path}: none of {_TRIES} drawn sets of effects could be measured; take another seed")


def read_case(path: Path, machine: str = "spheiro") -> Measurement:
    """What the diagnosis gets to see."""
    return read_measurement(path, shipped_machine(machine))


def open_seal(path: Path) -> Answer:
    """The answer to a log; only after its diagnosis."""
    content = json.loads(path.with_suffix(".sealed.json").read_text(encoding="utf-8"))
    names = tuple(effect["name"] for effect in content["effects"])
    noise = np.array(content["noise"])
    size = _size(np.array(content["effect_rms"]), noise)
    return Answer(names, size, np.array(content["effort"]), noise, content["mode"], np.array(content["unrepeated"]))


def _is_sealed(path: Path) -> bool:
    """Is there an answer to this log, with all that is asked of one?"""
    sealed = path.with_suffix(".sealed.json")
    return sealed.exists() and "unrepeated" in json.loads(sealed.read_text(encoding="utf-8"))


def _size(effect: np.ndarray, noise: np.ndarray) -> float:
    """RMS over the axes, each in parts of its noise."""
    return float(np.sqrt(np.mean((effect / noise) ** 2)))


def _draw(kind: str, mode: str, rng: np.random.Generator):
    """Imperfections for the machine that is then in the engine."""
    count = {"listed": 1, "pair": 2, "clean": 0, "unlisted": 1}[kind]
    pool = [name for name in DRAWN if mode != "static" or name not in NOT_IN_HOLDS]

    def effects(engine: Engine, sizes: Sizes) -> Sequence[Imperfection]:
        own = drawable(UNLISTED if kind == "unlisted" else pool, engine, sizes)
        while True:
            names = rng.choice(own, count, replace=False)
            if not any(len(same.intersection(names)) > 1 for same in ONE_EFFECT):
                return [drawn(str(name), rng, engine, sizes) for name in names]

    return effects


# What the first driver must be a function of: position, its own or another axis' force, direction, time.
_FOLLOWS = {
    "soft_stop": "q", "friction_bump": "q dir", "current_crosstalk": "f", "magnetic_saturation": "f",
    "periodic_disturbance": "t",
}  # fmt: skip


def is_driver(answer: Answer, drivers: list[dict]) -> bool:
    """Is the first driver of the report what the unlisted effect follows?"""
    return bool(drivers) and drivers[0]["variable"].rstrip("0123456789") in _FOLLOWS[answer.names[0]].split()
