"""What the formats cost: the core against the float network, in all and stage by stage, and the value that sets each.

All values of a table share one format, which its largest sets. One huge weight takes the bits of all the others, and no
sum overflows by it: only this comparison tells.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gravcomp.core.formats import FixedNetwork
from gravcomp.errors import InputError
from gravcomp.network.inputs import weight_columns
from gravcomp.network.weights import HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV, Network
from gravcomp.twin.network import core, input_stage, output_scaler

N_COUNTS, SEED = 20000, 43
# Of the largest f_scale, RMS. Ten times what the formats cost a network that uses their bits well, and a quarter of
# what the shipped one misses of the statics.
MAX_SHARE = 2.5e-4
WHOLE_MN = 12.0**-0.5  # RMS of what whole mN or mNm leave of any effort: small robots are not refused for it


@dataclass(frozen=True)
class Stage:
    """What one stage costs alone, RMS in mN, and the value that sets its format."""

    name: str
    rms_mn: float
    file: str
    row: int
    column: str
    value: float


@dataclass(frozen=True)
class Precision:
    """Error of the core against the float network at encoder counts of the trained range, mN; dearest stage first."""

    rms_mn: float
    largest_mn: float
    limit_mn: float
    stages: tuple[Stage, ...]

    def __str__(self) -> str:
        return (
            f"the formats cost {self.rms_mn:.2f} mN RMS, {self.largest_mn:.2f} mN at most "
            f"({N_COUNTS} positions, seed {SEED})"
        )


def precision(
    network: Network, fixed: FixedNetwork, step: float | np.ndarray, setter: Network | None = None
) -> Precision:
    """Fixed against float at N_COUNTS positions, uniform over the trained range of every axis.

    step: one encoder count. setter: the network whose formats these are, if another. Positions at which the core
    flags saturation are left out: those are told at run time.
    """
    rng = np.random.default_rng(SEED)
    counts = rng.integers(fixed.count_low, fixed.count_high + 1, (N_COUNTS, network.n_axes))
    answer, wanted_n = core(counts, fixed), network.forces(counts * step)
    error_mn = np.where(answer.saturated, 0.0, answer.force_mn - 1000.0 * wanted_n)
    stages = _stages(network, fixed, counts, step, ~answer.saturated, setter or network)
    return Precision(
        _rms(error_mn),
        float(np.abs(error_mn).max()),
        math.hypot(1000.0 * MAX_SHARE * float(network.f_scale.max()), WHOLE_MN),
        tuple(sorted(stages, key=lambda stage: -stage.rms_mn)),
    )


def certified(found: Precision, folder: Path | str, core_folder: Path | str | None = None) -> Precision:
    """The same, when it costs no more than its limit; else InputError naming the value that costs most.

    core_folder: the weights that set the formats, if others than those in folder.
    """
    if found.rms_mn <= found.limit_mn:
        return found
    stage = found.stages[0]
    where = f"{Path(core_folder or folder) / stage.file}: row {stage.row}, column {stage.column}: {stage.value:g}"
    mend = (
        f"load weights of the size of those that the core was built with, or build one from {folder}"
        if core_folder
        else "retrain with smaller values there, or spread this one over others"
    )
    raise InputError(
        f"{where} sets a format so coarse that forces are {found.rms_mn:.3g} mN RMS off, limit {found.limit_mn:.3g} mN "
        f"(its stage alone: {stage.rms_mn:.3g} mN); {mend}"
    )


def _stages(network: Network, fixed: FixedNetwork, counts, step, is_whole, setter: Network) -> list[Stage]:
    """Each stage in its format and all the others in float. is_whole (N, n): forces that do not saturate."""
    q_m = counts * step
    exact_n = network.forces(q_m)
    x_unit, y_unit_n = _units(network, fixed, step)
    hidden = replace(network, hidden_weights=np.ldexp(fixed.hidden_weights, -fixed.weight_fraction) / x_unit)
    output_weights = (
        np.ldexp(fixed.output_weights, -fixed.output_weight_fraction) * (y_unit_n / network.f_scale)[:, None]
    )
    output = replace(network, output_weights=output_weights)
    forces_n = {
        "positions": network.forces_of(_seen(network, fixed, counts, q_m, x_unit)),
        "hidden weights": hidden.forces(q_m),
        "output weights": output.forces(q_m),
        "forces": _scaled(fixed, exact_n, y_unit_n),
    }
    neurons = [f"v_{k}" for k in range(1, setter.n_hidden + 1)]
    sets = {
        "positions": _in_scaling(setter, "q_offset", setter.q_offset * setter.q_scale, "q_scale"),
        "hidden weights": (HIDDEN_CSV, *_largest(setter.hidden_weights, weight_columns(setter.inputs))),
        "output weights": (OUTPUT_CSV, *_largest(setter.output_weights, neurons)),
        "forces": _in_scaling(setter, "f_offset", setter.f_offset / setter.f_scale, "f_scale"),
    }
    return [
        Stage(name, 1000.0 * _rms(np.where(is_whole, forces - exact_n, 0.0)), *sets[name])
        for name, forces in forces_n.items()
    ]


def _units(network: Network, fixed: FixedNetwork, step) -> tuple[np.ndarray, np.ndarray]:
    """What an x of 1 is to the float network (p,), and a y of 1, N or Nm (n,): the scales that the lean form leaves
    out."""
    if not fixed.is_lean:
        return np.ones(fixed.n_inputs), network.f_scale
    return network.q_scale * step * 2.0**fixed.count_shift, np.full(fixed.n_axes, 1e-3)


def _seen(network: Network, fixed: FixedNetwork, counts: np.ndarray, q_m: np.ndarray, x_unit: np.ndarray) -> np.ndarray:
    """Inputs x (N, p) as the core sees them, without the offset that its biases make up for."""
    exact = network.x(q_m)
    error = np.ldexp(input_stage(counts, fixed)[0], -fixed.x_fraction) * x_unit - exact
    return exact + error - error.mean(axis=0)


def _scaled(fixed: FixedNetwork, forces_n: np.ndarray, y_unit_n: np.ndarray) -> np.ndarray:
    """Forces (N, n), N, through the last format and scale alone; the halves of what they truncate are in the bias."""
    half_y = 0.0 if fixed.is_lean else 2.0 ** -(fixed.y_fraction + 1)
    y = (forces_n + 0.5e-3) / y_unit_n + half_y
    fraction = fixed.output_drop + fixed.y_fraction
    return 1e-3 * output_scaler(np.floor(np.ldexp(y, fraction)).astype(np.int64), fixed)[0]


def _largest(values: np.ndarray, columns: Sequence[str]) -> tuple[int, str, float]:
    row, number = np.unravel_index(np.argmax(np.abs(values)), values.shape)
    return int(row) + 1, columns[number], float(values[row, number])


def _in_scaling(network: Network, offset: str, ratio: np.ndarray, scale: str) -> tuple[str, int, str, float]:
    """The offset that makes a format wider than its trained range needs, or else the largest scale."""
    column, sizes = (offset, np.abs(ratio)) if np.abs(ratio).max() > 1 else (scale, getattr(network, scale))
    row = int(np.argmax(sizes))
    return SCALING_CSV, row + 1, column, float(getattr(network, column)[row])


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))
