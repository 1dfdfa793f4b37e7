"""From a float network to the integers of the hardware: formats derived from bounds, constants, folded biases.

Every operand of a multiplier has 18 bits (one 18 x 18 block each); products and sums keep full precision. Bits are
dropped by truncation only, and the half LSB that truncation costs on average is folded into the bias downstream:
rounding is free in hardware. The offsets of both normalisations are folded in the same way, so an inference needs
166 multiplications and 43 sums at hidden size 20.

Signals, in order (code = value * 2**fraction, truncated):

    count -> clamp to the trained range -> count code (>> count_shift) -> x -> a = W x + b -> Gamma(a) = h
          -> acc = V h + b -> y -> force in mN

An axis with input sin_cos gives two x, sine and cosine of its phase, by another way: gravcomp.twin.sin_cos.

This is the paper's form of the network. gravcomp.core.lean makes the lean one of it, in the same FixedNetwork.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.facts import OPERAND_BITS
from gravcomp.network.inputs import SIN_COS, axis_of_input, weight_columns
from gravcomp.network.weights import HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV, Network
from gravcomp.robot.machine import LEAN, PAPER, ROBOT_TOML, SERIAL, Drive

COUNT_BITS = 32
FORCE_BITS = 24  # mN: +-8388 N
CURRENT_BITS = 32  # uA
ACCUMULATOR_BITS = 48  # the widest sum that any vendor's DSP column adds in one go

PHASE_BITS = 18  # of a turn
STEP_BITS = 35  # of a turn, in what a count adds to the phase: an operand, and the rest of one without its sign
SIN_COS_FRACTION = 17

PREACTIVATION_FRACTION = 16  # a in [-L, L) = [-2, 2)
SLOPE_FRACTION = 17  # beta - theta |a| in [1/2, 1)
HIDDEN_FRACTION = 17  # h = Gamma(a) in [-1, 1)

# The core clamps |x| to 1 - 2^-16: the trained range less two codes, so that x and its scale never overflow.
INPUT_LIMIT = 1.0 - 2.0**-16
# Head room of y over the trained range [-1, 1] before the output saturates.
OUTPUT_HEADROOM = 1.0625

OPERAND_MAX = 2 ** (OPERAND_BITS - 1) - 1
_SCALE_CODE_MIN = 1024  # a scale is then exact to 0.05 %
_FRACTION_MAX = 24  # finer weights than this would only widen the sums
_SCALE_FRACTION_MAX = 31  # half of it must fit a VHDL integer; products of 36 bits would vanish with more


@dataclass(frozen=True)
class FixedNetwork:
    """The integers and formats of one network in hardware. n axes, p inputs, h hidden neurons.

    inputs (n,): position or sin_cos. coarse_step, fine_step (n,): turns per 2^16 counts and per count of a sin_cos
    axis, modulo a turn, STEP_BITS fraction bits; 0 for the others.
    count_low, count_high (n,): clamp, encoder counts; of a sin_cos axis, which is not clamped, half of all, as a host
    is told. count_shift (n,): bits of the count dropped before scaling.
    input_scale, input_scale_fraction (n,): x = count_code * input_scale >> input_scale_fraction, x_fraction bits.
    x_low, x_high (p,): lowest and highest code of x over all encoder counts.
    hidden_weights (h, p) with weight_fraction; hidden_bias (h,) with x_fraction + weight_fraction.
    output_weights (n, h) with output_weight_fraction; output_bias (n,) with that + HIDDEN_FRACTION.
    output_scale, output_scale_fraction (n,): effort, mN or mNm, = y * output_scale >> output_scale_fraction, y of
    y_fraction bits.
    current_scale, current_scale_fraction (n,): current in uA = effort * current_scale >> current_scale_fraction, which
    saturates.
    hidden_sum_bits, output_sum_bits: widths in which no partial sum can overflow for any count (see bounds).
    y_bits: width to which y saturates.

    In the lean form (is_lean) both scales are 1, with no fraction: x is the count code and y the effort in mN or mNm,
    weights are per code of x and per mN. Products lose hidden_product_drop and output_product_drop bits before they
    are summed, and biases have as many fraction bits less.

    In the serial form (is_serial, and is_lean) all of that runs on one multiplier, of an operand and a weight, and in
    one sum: weights have weight_bits, both drops are one, and both sums as wide.
    """

    inputs: tuple[str, ...]
    coarse_step: np.ndarray
    fine_step: np.ndarray
    count_low: np.ndarray
    count_high: np.ndarray
    count_shift: np.ndarray
    input_scale: np.ndarray
    input_scale_fraction: np.ndarray
    x_fraction: int
    x_low: np.ndarray
    x_high: np.ndarray
    hidden_weights: np.ndarray
    weight_fraction: int
    hidden_bias: np.ndarray
    hidden_sum_bits: int
    output_weights: np.ndarray
    output_weight_fraction: int
    output_bias: np.ndarray
    output_sum_bits: int
    y_fraction: int
    output_scale: np.ndarray
    output_scale_fraction: np.ndarray
    current_scale: np.ndarray
    current_scale_fraction: np.ndarray
    y_bits: int = OPERAND_BITS
    hidden_product_drop: int = 0
    output_product_drop: int = 0
    is_lean: bool = False
    is_serial: bool = False
    weight_bits: int = OPERAND_BITS

    @property
    def form(self) -> str:
        """One of gravcomp.robot.machine.FORMS."""
        return SERIAL if self.is_serial else LEAN if self.is_lean else PAPER

    @property
    def n_hidden(self) -> int:
        return len(self.hidden_bias)

    @property
    def n_axes(self) -> int:
        return len(self.output_bias)

    @property
    def n_inputs(self) -> int:
        """Of the hidden layer: two per sin_cos axis."""
        return self.hidden_weights.shape[1]

    @property
    def is_turning(self) -> np.ndarray:
        """Whether each axis (n,) gives sine and cosine."""
        return np.array([kind == SIN_COS for kind in self.inputs])

    @property
    def preactivation_drop(self) -> int:
        """Bits that truncation drops from the hidden sum to the pre-activation a."""
        return self.x_fraction + self.weight_fraction - self.hidden_product_drop - PREACTIVATION_FRACTION

    @property
    def output_drop(self) -> int:
        """Bits that truncation drops from the output sum to y."""
        return HIDDEN_FRACTION + self.output_weight_fraction - self.output_product_drop - self.y_fraction


# Values that overflow a float become inf here, and no format holds inf.
@np.errstate(over="ignore", divide="ignore", invalid="ignore")
def quantise(
    network: Network, drive: Drive, folder: Path | str = "weights", formats: FixedNetwork | None = None
) -> FixedNetwork:
    """Derive formats and constants of the hardware from a float network.

    folder: where the network came from, for messages. formats: the network of a core that is built, whose size, widths,
    fractions and shifts are kept. Raises InputError naming file, row and column when a format cannot hold a value.
    """
    folder, kept = Path(folder), vars(formats) if formats else {}
    if formats:
        check_size(network, formats, folder)
    inputs = _input_stage(network, drive, folder / SCALING_CSV, kept)
    if formats:
        _check_turns(inputs, formats, folder / ROBOT_TOML)
    hidden = _hidden_stage(network, drive, inputs, folder / HIDDEN_CSV, kept)
    outputs = _output_stage(network, folder, kept)
    where = f"{folder / ROBOT_TOML}: axis {{row}}: effort_per_ampere"
    # At least one bit, as the current is rounded.
    current_scale, current_scale_fraction = _scales(
        1000.0 / drive.effort_per_ampere, where, kept.get("current_scale_fraction"), least=1
    )
    return FixedNetwork(
        **inputs,
        **hidden,
        **outputs,
        current_scale=current_scale,
        current_scale_fraction=current_scale_fraction,
    )


def check_size(network: Network, formats: FixedNetwork, folder: Path) -> None:
    """Raise InputError unless a network has the size and the inputs of a core that is built."""
    if (network.n_axes, network.n_hidden) != (formats.n_axes, formats.n_hidden):
        raise InputError(
            f"{folder}: {network.n_axes} axes and {network.n_hidden} neurons, but the core has {formats.n_axes} and "
            f"{formats.n_hidden}; give a network of its size"
        )
    if network.inputs != formats.inputs:
        raise InputError(
            f"{folder / HIDDEN_CSV}: inputs {', '.join(network.inputs)}, but the core has {', '.join(formats.inputs)}; "
            "give a network of its inputs"
        )


def partial_sum_interval(weights: np.ndarray, bias: np.ndarray, low, high, drop: int = 0) -> tuple[int, int]:
    """Interval of every partial sum of bias + weights @ signal, in any order of addition, signal in [low, high].

    weights (m, k), bias (m,), low and high scalars or (k,): integers. Each product loses drop bits by truncation first.
    Returns (lowest, highest).
    """
    extremes = np.stack([weights * low, weights * high]) >> drop
    lowest = np.minimum(extremes.min(axis=0), 0).sum(axis=1) + np.minimum(bias, 0)
    highest = np.maximum(extremes.max(axis=0), 0).sum(axis=1) + np.maximum(bias, 0)
    return int(lowest.min()), int(highest.max())


def bits_for(low: int, high: int) -> int:
    """Width of the signed number that holds both ends of an interval."""
    return 1 + max((-low - 1).bit_length() if low < 0 else 0, high.bit_length() if high > 0 else 0)


def _input_stage(network: Network, drive: Drive, path: Path, kept: Mapping) -> dict:
    is_phase = np.array([kind == SIN_COS for kind in network.inputs])
    if is_phase.any() and network.q_offset[is_phase].any():
        row = int(np.flatnonzero(is_phase & (network.q_offset != 0))[0]) + 1
        raise InputError(
            f"{path}: row {row}, column q_offset: not 0, but the input is sin_cos; turn the weights instead"
        )
    low, high = _clamp(network, drive, is_phase, path)
    count_shift = shift_of_counts(
        np.where(is_phase, 0, low), np.where(is_phase, 0, high), path, kept.get("count_shift")
    )
    x_offset = network.q_offset * network.q_scale
    x_fraction = fraction_for(np.abs(x_offset)[:, None] + INPUT_LIMIT, path, ["q_offset"], kept.get("x_fraction"))
    per_code = 2.0**count_shift * drive.unit_per_count * network.q_scale * 2.0**x_fraction
    where = f"{path}: row {{row}}, column q_scale"
    input_scale, input_scale_fraction = _scales(per_code, where, kept.get("input_scale_fraction"), used=~is_phase)
    # Clamp and scale are monotonic: the ends of the trained range give the ends of x.
    x_low, x_high = ((end >> count_shift) * input_scale >> input_scale_fraction for end in (low, high))
    most = (2**SIN_COS_FRACTION - 1) >> SIN_COS_FRACTION - x_fraction
    axis = axis_of_input(network.inputs)
    return {
        "inputs": network.inputs,
        "coarse_step": _turn_steps(drive, is_phase, 2.0 ** (COUNT_BITS // 2)),
        "fine_step": _turn_steps(drive, is_phase, 1.0),
        "count_low": low,
        "count_high": high,
        "count_shift": count_shift,
        "input_scale": input_scale,
        "input_scale_fraction": input_scale_fraction,
        "x_fraction": x_fraction,
        "x_low": np.where(is_phase, -most - 1, x_low)[axis],
        "x_high": np.where(is_phase, most, x_high)[axis],
    }


def _turn_steps(drive: Drive, is_phase: np.ndarray, n_counts: float) -> np.ndarray:
    """Turns (n,) per so many counts, modulo a turn: signed codes of STEP_BITS; 0 where no phase is."""
    turns = np.where(is_phase, n_counts / (2 * np.pi * drive.counts_per_unit), 0.0)
    codes = np.rint(2.0**STEP_BITS * np.mod(turns, 1.0)).astype(np.int64)
    half = 1 << STEP_BITS - 1
    return (codes + half) % (2 * half) - half


def _check_turns(inputs: Mapping, formats: FixedNetwork, path: Path) -> None:
    """Raise InputError where a turn has other counts than in the core: its steps are no part of an image."""
    for name in ("coarse_step", "fine_step"):
        for axis in np.flatnonzero(inputs[name] != getattr(formats, name)):
            raise InputError(
                f"{path}: axis {axis + 1}: counts_per_turn is another than that of the core, which an image does not "
                "change; give that"
            )


def _clamp(network: Network, drive: Drive, is_phase: np.ndarray, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The counts (n,) to which those of each axis are clamped: the trained range, or all where the phase wraps."""
    centre = network.q_offset / drive.unit_per_count
    reach = INPUT_LIMIT / network.q_scale / drive.unit_per_count
    low, high = np.ceil(centre - reach), np.floor(centre + reach)
    for row in np.flatnonzero(~is_phase):
        if not -(2 ** (COUNT_BITS - 1)) < low[row] <= high[row] < 2 ** (COUNT_BITS - 1):
            raise InputError(
                f"{path}: row {row + 1}, column q_scale: the trained range is {low[row]:.0f} to {high[row]:.0f} "
                f"encoder counts; it must hold a count and fit {COUNT_BITS} bits"
            )
    most = 2 ** (COUNT_BITS - 2)  # half of all counts: a host adds its margin to what it is told
    return tuple(np.where(is_phase, all_, end).astype(np.int64) for all_, end in ((-most, low), (most, high)))


def _hidden_stage(network: Network, drive: Drive, inputs: Mapping, path: Path, kept: Mapping) -> dict:
    columns = weight_columns(network.inputs)
    weight_fraction = fraction_for(network.hidden_weights, path, columns, kept.get("weight_fraction"))
    weights = codes(network.hidden_weights, weight_fraction)
    # What the code of x lacks on average: half its LSB, the dropped bits of the count, the offset of the scaling.
    dropped_count = (2.0 ** inputs["count_shift"] - 1) / 2
    x_lacks = (
        2.0 ** -(inputs["x_fraction"] + 1) + (dropped_count * drive.unit_per_count - network.q_offset) * network.q_scale
    )
    # Sine and cosine are rounded, then lose what x has no bits for.
    of_phase = 2.0 ** -(inputs["x_fraction"] + 1) - 2.0 ** -(SIN_COS_FRACTION + 1)
    axis = axis_of_input(network.inputs)
    is_phase = np.array([kind == SIN_COS for kind in network.inputs])
    x_lacks = np.where(is_phase, of_phase, x_lacks)[axis]
    bias = network.hidden_bias + weights * 2.0**-weight_fraction @ x_lacks + 2.0 ** -(PREACTIVATION_FRACTION + 1)
    sum_fraction = inputs["x_fraction"] + weight_fraction
    if sum_fraction < PREACTIVATION_FRACTION:
        raise InputError(f"{path}: weights too large for the range of x in scaling.csv; retrain with smaller ones")
    bias = bias_codes(bias, sum_fraction, path)
    interval = partial_sum_interval(weights, bias, inputs["x_low"], inputs["x_high"])
    return {
        "hidden_weights": weights,
        "weight_fraction": weight_fraction,
        "hidden_bias": bias,
        "hidden_sum_bits": sum_bits(interval, sum_fraction - PREACTIVATION_FRACTION, path, kept.get("hidden_sum_bits")),
    }


def _output_stage(network: Network, folder: Path, kept: Mapping) -> dict:
    path, scaling = folder / OUTPUT_CSV, folder / SCALING_CSV
    columns = [f"v_{j}" for j in range(1, network.n_hidden + 1)]
    weight_fraction = fraction_for(network.output_weights, path, columns, kept.get("output_weight_fraction"))
    weights = codes(network.output_weights, weight_fraction)
    f_ratio = network.f_offset / network.f_scale
    y_largest = (np.abs(f_ratio)[:, None] + 1.0) * OUTPUT_HEADROOM
    y_fraction = fraction_for(y_largest, scaling, ["f_offset / f_scale"], kept.get("y_fraction"))
    where = f"{scaling}: row {{row}}, column f_scale"
    output_scale, scale_fraction = _scales(
        1000.0 * network.f_scale * 2.0**-y_fraction, where, kept.get("output_scale_fraction")
    )
    for row in np.flatnonzero(2 * OPERAND_BITS - 1 - scale_fraction > FORCE_BITS):
        raise InputError(
            f"{where.format(row=row + 1)}: efforts exceed {FORCE_BITS} bits of mN or mNm; give a smaller scale"
        )
    # The halves of what truncation drops from h, from y, and from the force in mN.
    lacks = (
        weights.sum(axis=1) * 2.0 ** -(weight_fraction + HIDDEN_FRACTION + 1)
        + 2.0 ** -(y_fraction + 1)
        + 0.5e-3 / network.f_scale
    )
    if HIDDEN_FRACTION + weight_fraction < y_fraction:
        raise InputError(f"{path}: weights too large for the range of y in {SCALING_CSV}; retrain with smaller ones")
    bias = bias_codes(network.output_bias + f_ratio + lacks, HIDDEN_FRACTION + weight_fraction, path)
    interval = partial_sum_interval(weights, bias, -(2**HIDDEN_FRACTION), 2**HIDDEN_FRACTION - 1)
    return {
        "output_weights": weights,
        "output_weight_fraction": weight_fraction,
        "output_bias": bias,
        "output_sum_bits": sum_bits(
            interval, HIDDEN_FRACTION + weight_fraction - y_fraction, path, kept.get("output_sum_bits")
        ),
        "y_fraction": y_fraction,
        "output_scale": output_scale,
        "output_scale_fraction": scale_fraction,
    }


def shift_of_counts(low: np.ndarray, high: np.ndarray, path: Path, kept: np.ndarray | None) -> np.ndarray:
    """Bits of each axis' count (n,) to drop so that its limits fit an operand, or those that the core drops."""
    needed = [bits_for(int(ends[0]), int(ends[1])) for ends in zip(low, high, strict=True)]
    least = np.maximum(0, np.array(needed, dtype=np.int64) - OPERAND_BITS)
    if kept is None:
        return least
    for row in np.flatnonzero(least > kept):
        raise InputError(
            f"{path}: row {row + 1}, column q_scale: the trained range is wider than the {OPERAND_BITS + kept[row]} "
            "bits of counts that the core takes; give a larger scale"
        )
    return kept


def fraction_for(
    values: np.ndarray,
    path: Path,
    columns: list[str],
    kept: int | None = None,
    ends: tuple[int, int] = (0, _FRACTION_MAX),
    bits: int = OPERAND_BITS,
) -> int:
    """Most fraction bits, within ends, with which a code of so many bits holds every value of a table (rows, columns),
    or kept ones."""
    row, column = np.unravel_index(np.argmax(np.abs(values)), values.shape)
    largest = abs(float(values[row, column]))
    least, most = ends if kept is None else (kept, kept)
    fraction = least - 1 if math.isinf(largest) else most
    if 0 < largest < math.inf:
        fraction = bits - 1 - math.ceil(math.log2(largest))
    if fraction >= least and round(largest * 2.0**fraction) >= 2 ** (bits - 1):
        fraction -= 1
    if fraction < least:
        raise InputError(
            f"{path}: row {row + 1}, column {columns[column]}: {values[row, column]:g} does not fit "
            f"{bits} bits (limit {(2 ** (bits - 1) - 1) / 2**least:.6g}); give smaller values"
        )
    return min(fraction, most)


def codes(values: np.ndarray, fraction: int) -> np.ndarray:
    return np.rint(values * 2.0**fraction).astype(np.int64)


def bias_codes(bias: np.ndarray, fraction: int, path: Path) -> np.ndarray:
    row = int(np.argmax(np.abs(bias)))
    if abs(bias[row]) * 2.0**fraction >= 2 ** (ACCUMULATOR_BITS - 1):
        raise InputError(
            f"{path}: row {row + 1}, column bias: {bias[row]:g} does not fit the sum's {ACCUMULATOR_BITS} bits; "
            "give a smaller bias"
        )
    return codes(bias, fraction)


def sum_bits(interval: tuple[int, int], drop: int, path: Path, kept: int | None) -> int:
    """Width of a sum from which drop bits are dropped next, at least one operand wide after that, or a kept width."""
    bits, limit = max(bits_for(*interval), drop + OPERAND_BITS), kept or ACCUMULATOR_BITS
    if bits > limit:
        raise InputError(f"{path}: its sums need {bits} bits, more than {limit}; give smaller weights")
    return kept or bits


def _scales(
    factors: np.ndarray, where: str, kept: np.ndarray | None, used: np.ndarray | None = None, least: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Positive factors (n,) as 18-bit codes and their fraction bits, (n,) each: as many as fit, at least so many, or
    kept ones.

    where names a factor, with {row} for its number. Those that are not used get the code 0.
    """
    codes, fractions = np.zeros(len(factors), dtype=np.int64), np.zeros(len(factors), dtype=np.int64)
    for i in range(len(factors)) if used is None else np.flatnonzero(used):
        floor = least if kept is None else int(kept[i])
        codes[i], fractions[i] = _scale(float(factors[i]), where.format(row=i + 1), floor, kept is not None)
    return codes, fractions


def _scale(factor: float, where: str, least: int, is_kept: bool) -> tuple[int, int]:
    """A factor as a code and its fraction bits: as many as fit, or with is_kept the least."""
    most = math.floor(math.log2(OPERAND_MAX) - math.log2(factor)) if 0 < factor < math.inf else -1
    if not least <= most:
        raise InputError(f"{where} is too large or small for {OPERAND_BITS} bits; check its unit")
    fraction = least if is_kept else min(most, _SCALE_FRACTION_MAX)
    code = round(factor * 2.0**fraction)
    if code < _SCALE_CODE_MIN:
        how = "for the format of the core; give a scale like that of its ROM" if is_kept else "; check its unit"
        raise InputError(f"{where} is too small {how}".replace(" ;", ";"))
    return code, fraction
