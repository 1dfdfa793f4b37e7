"""Records of gc_recorder, from words as they are read to the measured CSV. gc_recorder.vhd has the layout."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.machine import EFFORT_UNITS, Machine
from gravcomp.twin.encoder import NO_PERIOD
from gravcomp.twin.recorder import FIELDS, LOST_BEFORE, STALE, words_of

_COUNTS_PER_PERIOD = 4
_RATES = {"m": "mps", "rad": "radps"}


@dataclass(frozen=True)
class Records:
    """Records of n axes, int64: tick and status (k,); count, period (clocks per four counts, signed), sense and command
    (uA), force (mN or mN m) (k, n). was_lost: records are missing before this one; is_stale: a current is not new."""

    tick: np.ndarray
    status: np.ndarray
    count: np.ndarray
    period: np.ndarray
    sense: np.ndarray
    command: np.ndarray
    force: np.ndarray
    was_lost: np.ndarray
    is_stale: np.ndarray


def records_of(words: Sequence[int] | np.ndarray, n_axes: int) -> Records:
    """Records from the words of gc_recorder, each 0 .. 2**32 - 1, whole records one after the other.

    The tick number goes on where its 32 bits wrap. Raises InputError when the words do not end with a record.
    """
    words, size = np.asarray(words, np.int64), words_of(n_axes)
    if words.size % size:
        raise InputError(f"records: {words.size} words are not whole records of {size} words; read a whole one again")
    table = words.reshape(-1, size)
    steps = np.diff(table[:, 0], prepend=table[:1, 0]) % 2**32
    signed = (table[:, 2:] + 2**31) % 2**32 - 2**31
    fields = signed.reshape(len(table), n_axes, len(FIELDS))
    flags = table[:, 1]
    return Records(
        tick=(table[0, 0] if len(table) else 0) + np.cumsum(steps),
        status=flags & (STALE - 1),
        was_lost=(flags & LOST_BEFORE) != 0,
        is_stale=(flags & STALE) != 0,
        **{name: fields[:, :, k] for k, name in enumerate(FIELDS)},
    )


def speeds(period: np.ndarray, clock_hz: float) -> np.ndarray:
    """Counts per second, signed, of clocks per four counts; 0 at standstill and while the speed is not known."""
    return np.where(period == NO_PERIOD, 0.0, _COUNTS_PER_PERIOD * clock_hz / np.where(period == 0, 1, period))


def measured_csv(
    records: Records,
    machine: Machine,
    tick_s: float,
    *,
    approach: np.ndarray | None = None,
    with_feed_forward: bool = False,
) -> str:
    """The measured CSV: t_s from the first record on, positions, velocities, measured currents in amperes.

    approach (k, n), m/s or rad/s, signed: velocities with which holds were approached, in place of those of the
    encoders. with_feed_forward: also fm{i}_n or fm{i}_nm, what the core held to be needed. Left out are records without
    a measured current of their own. Raises InputError when none is left, or shapes do not fit the machine.
    """
    n_axes = records.count.shape[1]
    if n_axes != machine.n_axes:
        raise InputError(f"records: {n_axes} axes, but {machine.where} has {machine.n_axes}; give the machine recorded")
    per_count = machine.drive.unit_per_count
    v = speeds(records.period, machine.clock_hz) * per_count if approach is None else np.asarray(approach, float)
    if v.shape != records.count.shape:
        raise InputError(
            f"records: approach velocities are {v.shape}, records {records.count.shape}; give one for each"
        )
    kept = ~records.is_stale
    if not kept.any():
        raise InputError("records: no measured current in any of them; wire sense_valid and sense_current")
    columns = {"t_s": (records.tick - records.tick[0]) * tick_s}
    kinds = [("q", machine.position_units, machine.drive.positions(records.count))]
    kinds.append(("v", [_RATES[unit] for unit in machine.position_units], v))
    kinds.append(("i", ["a"] * n_axes, records.sense * 1e-6))
    if with_feed_forward:
        efforts = [EFFORT_UNITS[unit].lower() for unit in machine.position_units]
        kinds.append(("fm", efforts, records.force * 1e-3))
    for kind, units, values in kinds:
        columns |= {f"{kind}{i + 1}_{unit}": values[:, i] for i, unit in enumerate(units)}
    table = np.column_stack(list(columns.values()))[kept]
    lines = [",".join(columns), *(",".join(f"{value:.10g}" for value in row) for row in table)]
    return "\n".join(lines) + "\n"
