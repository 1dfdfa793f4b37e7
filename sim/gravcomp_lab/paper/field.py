"""Measuring on the field: holds of given poses and slow motion of the prototype that errs as the paper's robot does."""

import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from gravcomp.diagnosis.model import Model
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.measurement import Measurement
from gravcomp.prototype import DEFAULT_NOISE_N
from gravcomp.prototype.experiment import PrototypeLog, as_log, hold, log_csv, measure
from gravcomp.prototype.imperfections import field_effects
from gravcomp.prototype.plant import Plant
from gravcomp.prototype.travel import travel_of, turning_rates
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.robot import spheiro_of

APPROACHES = ("random", "outward")


def hold_field(machine: Machine, poses: np.ndarray, approach: str, seed: int) -> Measurement:
    """Hold poses (n, 3, 3), each approached from a random side that moves every joint, or moving outward from home.

    Returns what a reader of the log sees, n rows.
    """
    rng = np.random.default_rng(seed)
    p = spheiro_of(machine)
    targets = inverse_kinematics(poses, p)
    if approach == "outward":
        rates = turning_rates(poses, Rotation.from_matrix(poses).as_rotvec(), p)
    else:
        rates = travel_of(machine).rates(targets, rng)
    with tqdm(total=len(poses), desc=f"holds, approach {approach}", delay=2.0, unit="pose") as progress:
        samples = hold(Plant(machine, field_effects()), targets, rates, progress)
    return _as_read(as_log(samples, machine, np.full(3, DEFAULT_NOISE_N), rng), machine)


def move_field(machine: Machine, n_samples: int, seed: int) -> Measurement:
    """Slow motion through the workspace, there and back."""
    return _as_read(measure(machine, field_effects(), n_samples, seed, mode="motion"), machine)


def true_forces(data: Measurement) -> np.ndarray:
    """Forces (n, 3), N, by the equations of the effects that the prototype really has, friction fully developed."""
    effects = []
    for effect in field_effects():
        given = effect.parameters()
        if effect.name == "passive_joint_friction":
            found = {"fc_prismatic_n": float(np.mean(given["fc_b"])), "fc_rotary_nm": float(np.mean(given["fc_phi"]))}
        else:
            name = {"coulomb_friction": "fc", "link_compliance": "c", "backlash": "gap"}[effect.name]
            found = {f"{name}_{axis}": value for axis, value in enumerate(given[name], start=1)}
        effects.append((effect.name, found))
    return data.nominal + Model(effects=effects).predict(data)


def _as_read(log: PrototypeLog, machine: Machine) -> Measurement:
    """The log through its CSV, so that nothing but that reaches a fit."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "field.csv"
        path.write_text(log_csv(log, machine), encoding="utf-8")
        return read_measurement(path, machine)
