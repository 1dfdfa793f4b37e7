"""Where a found effect goes: into the compensator's constants, into the network by training it again, or nowhere.

The compensator takes what depends on direction and speed, and cogging; the network what varies slowly with the
position. What depends on time, on acceleration or on the way to a position has no place in this hardware.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gravcomp.diagnosis.corrections import Correction
from gravcomp.diagnosis.effects import effect_named
from gravcomp.diagnosis.effects.base import axis_of
from gravcomp.diagnosis.model import Model
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.retraining import N_POSES, augmented_set, retrained
from gravcomp.network.compensation_csv import (
    FRICTION,
    MAX_HARMONIC,
    Compensation,
    check_compensation,
    no_compensation,
)
from gravcomp.network.weights import Network

DEFAULT_CLOCK_HZ = 100e6
# Speeds from which on friction is whole; it is zero below half of that. The lower limit is about ten counts a second.
FULL_FRICTION_MPS = (2e-5, 1e-4)


@dataclass(frozen=True)
class Placement:
    """Found effects by place: constants and names for the compensator, names for the network, and those for nowhere."""

    compensation: Compensation
    in_compensator: list[str]
    in_network: list[str]
    nowhere: list[str]


def into_hardware(
    model: Model, data: Measurement, network: Network, seed: int, n_poses: int = N_POSES
) -> tuple[Network, Placement, list[str]]:
    """The network trained again on the model's statics, the compensator's part, and the corrections in the network.

    The model's effects were found in data. Empirical corrections that depend on positions alone go into the network
    too. Raises InputError for effects that the hardware cannot hold.
    """
    effects = [{"name": name, "params": params} for name, params in model.effects]
    placement = compensation_from_effects(effects, data)
    in_network = [(name, params) for name, params in model.effects if name in placement.in_network]
    corrections = [(correction, values) for correction, values in model.corrections if is_of_position(correction)]
    if in_network or corrections:
        lacking = replace(model, effects=in_network, corrections=corrections)
        network, _ = retrained(network, augmented_set(lacking, model.robot, seed, n_poses), model.robot)
    return network, placement, [correction.label for correction, _ in corrections]


def is_of_position(correction: Correction) -> bool:
    """Does the correction depend on positions (or model forces, which follow from them) alone?"""
    return all(name[0] in "qf" for name in correction.variables) and not correction.by_direction


def compensation_from_effects(
    effects: Sequence[Mapping], data: Measurement, clock_hz: float = DEFAULT_CLOCK_HZ
) -> Placement:
    """Place effects, each {"name": ..., "params": {...}} as in report.json, found in data of the robot.

    Friction that several effects bring adds up. Friction of passive joints becomes what it is on average on each axis
    in this data; presliding hysteresis the friction that it ends in. Friction is whole at all but the slowest 5 % of
    the speeds, and held beyond the fastest, as no fit has seen it there. Raises InputError for effects that the
    compensator cannot hold.
    """
    constants, places = no_compensation(data.n_axes), {"compensator": [], "network": [], "none": []}
    for effect in effects:
        name, params = effect["name"], effect["params"]
        where = "compensator" if name in _TO_CONSTANTS else effect_named(name).hardware
        places[where].append(name)
        if where == "compensator":
            _add(constants, _TO_CONSTANTS[name](params, data))
    if any(getattr(constants, name).any() for name in FRICTION):
        speeds = np.abs(data.v[data.v != 0])
        full = np.clip(np.quantile(speeds, 0.05), *FULL_FRICTION_MPS)
        common = {"clock_hz": clock_hz, "v_dead_mps": full / 2, "v_full_mps": full, "v_max_mps": speeds.max()}
        constants = replace(constants, **{name: np.full(data.n_axes, value) for name, value in common.items()})
    check_compensation(constants, "found effects")
    return Placement(constants, places["compensator"], places["network"], places["none"])


def _per_axis(params: Mapping[str, float], stem: str, n_axes: int) -> np.ndarray:
    """Parameters stem_1, stem_2, ...; zero where an axis has none."""
    return np.array([params.get(f"{stem}_{axis}", 0.0) for axis in range(1, n_axes + 1)])


def _coulomb(params, data) -> dict:
    both, up, down = (_per_axis(params, stem, data.n_axes) for stem in ("fc", "fc_pos", "fc_neg"))
    return {"fc_pos_n": both + up, "fc_neg_n": both + down}


def _viscous(params, data) -> dict:
    both, up, down = (_per_axis(params, stem, data.n_axes) for stem in ("b", "b_pos", "b_neg"))
    return {"b_pos_ns_per_m": both + up, "b_neg_ns_per_m": both + down}


def _stribeck(params, data) -> dict:
    fc, fs, vs = (_per_axis(params, stem, data.n_axes) for stem in ("fc", "fs", "vs"))
    return {"fc_pos_n": fc, "fc_neg_n": fc, "stribeck_n": fs - fc, "vs_mps": vs}


def _load_dependent(params, data) -> dict:
    return {"mu": _per_axis(params, "mu", data.n_axes)}


def _passive(params, data) -> dict:
    """The Coulomb friction that is nearest to these forces in the mean square."""
    force = effect_named("passive_joint_friction").predict(data, params)
    friction_n = np.mean(force * data.direction, axis=0)
    return {"fc_pos_n": friction_n, "fc_neg_n": friction_n}


def _cogging(params, data) -> dict:
    waves = no_compensation(data.n_axes)
    for label, amplitude_n in params.items():
        if label.startswith("amplitude_"):
            tail, axis = label.removeprefix("amplitude_"), axis_of(label)
            harmonic = int(tail.split("_h")[1])
            if harmonic > MAX_HARMONIC:
                raise InputError(
                    f"effect cogging: harmonic {harmonic} is above {MAX_HARMONIC}; delete it from the model"
                )
            waves.a_n[axis, harmonic - 1], waves.p_rad[axis, harmonic - 1] = amplitude_n, params[f"phase_{tail}"]
    return {"pitch_m": np.full(data.n_axes, params["pitch"]), "a_n": waves.a_n, "p_rad": waves.p_rad}


_TO_CONSTANTS = {
    "coulomb_friction": _coulomb,
    "viscous_friction": _viscous,
    "stribeck_friction": _stribeck,
    "load_dependent_friction": _load_dependent,
    "passive_joint_friction": _passive,
    "presliding_hysteresis": _coulomb,
    "cogging": _cogging,
}


def _add(constants: Compensation, more: Mapping[str, np.ndarray]) -> None:
    for name, value in more.items():
        own = getattr(constants, name)
        if name in ("pitch_m", "vs_mps") and own.any():
            raise InputError(f"found effects: two of them give {name}; the compensator holds one")
        own += value
