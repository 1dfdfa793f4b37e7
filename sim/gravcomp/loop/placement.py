"""Where a found effect goes: into the compensator's constants, into the network by training it again, or nowhere.

The compensator takes what depends on direction and speed, and cogging; the network what varies slowly with the
position. What depends on time, on acceleration or on the way to a position has no place in this hardware.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gravcomp.core.compensation import (
    FRICTION,
    Compensation,
    check_compensation,
    no_compensation,
)
from gravcomp.diagnosis.effects import effect_named
from gravcomp.diagnosis.model import Model
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.retraining import N_POSES, augmented_set
from gravcomp.network.weights import Network
from gravcomp.robot.machine import Drive
from gravcomp.training.fine_tuning import retrained

# Speeds from which on friction is whole, within these, counts per second; it is zero below half of that.
FULL_FRICTION_COUNTS_PER_S = (20, 100)


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
    placement = compensation_from_effects(effects, data, model.machine.drive)
    in_network = [(name, params) for name, params in model.effects if name in placement.in_network]
    corrections = [(correction, values) for correction, values in model.corrections if correction.is_of_position]
    if in_network or corrections:
        lacking = replace(model, effects=in_network, corrections=corrections)
        network, _ = retrained(network, augmented_set(lacking, seed, n_poses), model.machine.drive)
    return network, placement, [correction.name for correction, _ in corrections]


def compensation_from_effects(effects: Sequence[Mapping], data: Measurement, drive: Drive) -> Placement:
    """Place effects, each {"name": ..., "params": {...}} as in report.json, found in data of the robot.

    Friction that several effects bring adds up. Friction of passive joints becomes what it is on average on each axis
    in this data; presliding hysteresis the friction that it ends in. Friction is whole at all but the slowest 5 % of
    an axis' speeds, and held beyond its fastest, as no fit has seen it there. Raises InputError for effects that the
    compensator cannot hold.
    """
    constants, places = no_compensation(data.n_axes), {"compensator": [], "network": [], "none": []}
    for effect in effects:
        known = effect_named(effect["name"])
        places[known.hardware].append(known.name)
        if known.hardware != "none":
            _add(constants, known.constants(data, effect["params"]))
    if any(getattr(constants, name).any() for name in FRICTION):
        full, fastest = _speed_range(data.v, drive)
        constants = replace(constants, v_dead=full / 2, v_full=full, v_max=fastest)
    check_compensation(constants, "found effects")
    return Placement(constants, places["compensator"], places["network"], places["none"])


def _speed_range(v: np.ndarray, drive: Drive) -> tuple[np.ndarray, np.ndarray]:
    """Speeds (n,) from which on friction is whole, and the fastest, of speeds v (N, n); alike for an axis at rest."""
    slowest, most = np.outer(FULL_FRICTION_COUNTS_PER_S, drive.unit_per_count)
    seen = [np.abs(own[own != 0]) if own.any() else most[axis : axis + 1] for axis, own in enumerate(v.T)]
    full = np.clip([np.quantile(own, 0.05) for own in seen], slowest, most)
    return full, np.array([own.max() for own in seen])


def _add(constants: Compensation, more: Mapping[str, np.ndarray]) -> None:
    for name, value in more.items():
        own = getattr(constants, name)
        if name in ("pitch", "vs") and own.any():
            raise InputError(f"found effects: two of them give {name}; the compensator holds one")
        own += value
