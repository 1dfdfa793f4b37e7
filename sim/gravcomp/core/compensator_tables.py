"""The integer tables of the compensator, from the constants. Their bit-true use: ``gravcomp.twin.compensator``.

Per axis, f_out = f + friction(v) + mu(v) |f| + cogging(q), saturated; all in mN. One entity of rtl/ per function.
Friction and mu are tables over a floating code of the speed meter's period P (clocks per 4 counts, v = 4 f_clk/P per
count): direction, exponent, three mantissa bits, so eight nodes per octave of speed, linear in P between them. The
dead band lies in the tables: from the first node at or below v_dead on, all nodes are zero. A period of 2**31 - 1
(standstill, reversal, dither about one edge: no speed is known) is in the last octave, where every table is zero.
The position table has 256 nodes over one pitch, linear between them; phase = (count * phase_step) modulo 2**32 turns.

Overflow: none before the final saturation, for any input; ``check_bounds`` shows it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.compensation import COMPENSATION_CSV, Compensation
from gravcomp.errors import InputError
from gravcomp.facts import POSITION_ADDRESS_BITS, SPEED_ADDRESS_BITS
from gravcomp.robot.machine import Drive

PERIOD_BITS = 32
MANTISSA_BITS = SPEED_ADDRESS_BITS - PERIOD_BITS.bit_length()  # beside direction and exponent
N_SPEEDS = PERIOD_BITS << MANTISSA_BITS  # nodes per direction
N_POSITIONS = 2**POSITION_ADDRESS_BITS
FRACTION_BITS = q.OPERAND_BITS - 1  # of the place between two nodes
MU_FRACTION = q.OPERAND_BITS - 1
PHASE_BITS = 32
PHASE_STEP_BITS = 25  # a pitch of at least 512 counts, two per node of the table
FRICTION_BITS = 25  # widths of gc_friction's output and of the sums in gc_compensator
TOTAL_BITS = 26

_SLOWEST = N_SPEEDS - (2 << MANTISSA_BITS)  # first node of the octave that stands for standstill
_OPERAND_MAX = 2 ** (q.OPERAND_BITS - 1) - 1


@dataclass(frozen=True)
class FixedCompensation:
    """The integers of the compensator for n axes.

    friction, mu (n, 2 N_SPEEDS, 2): value and step to the next node, moving up first; mN, and 2**-MU_FRACTION.
    position (n, N_POSITIONS, 2): value and step, mN. phase_step (n,): turns per count, 2**-PHASE_BITS.
    """

    friction: np.ndarray
    mu: np.ndarray
    position: np.ndarray
    phase_step: np.ndarray

    @property
    def n_axes(self) -> int:
        return len(self.phase_step)


def node_speeds(drive: Drive) -> np.ndarray:
    """Speeds (N_SPEEDS, n) of the nodes of friction and mu, m/s or rad/s, falling."""
    octave, eighth = np.divmod(np.arange(N_SPEEDS), 2**MANTISSA_BITS)
    period = 2.0**octave * (1 + eighth / 2**MANTISSA_BITS)
    return 4 * drive.clock_hz * drive.unit_per_count / period[:, None]


def quantise_compensation(c: Compensation, drive: Drive, folder: Path | str = "weights") -> FixedCompensation:
    """Tables of the hardware from the constants; folder names their source. Raises InputError when one doesn't fit."""
    where = Path(folder) / COMPENSATION_CSV
    speed = node_speeds(drive)
    turns = np.arange(N_POSITIONS)[:, None] / N_POSITIONS * np.ones(c.n_axes)
    cogging_mn = np.rint(1e3 * c.cogging(turns))
    pitch_counts = c.pitch / drive.unit_per_count
    coulomb = np.maximum(np.abs(c.fc_pos), np.abs(c.fc_neg)) + np.maximum(c.stribeck, 0.0)
    limit = _OPERAND_MAX / 1e3
    limits = {
        "v_dead is too slow for clock_hz; raise it": (c.v_dead > 0) & (speed[_SLOWEST] > c.v_dead),
        f"pitch is below {2 * N_POSITIONS} counts; raise it": (c.pitch > 0) & (pitch_counts < 2 * N_POSITIONS),
        f"Coulomb and Stribeck friction exceed {limit:g} N or Nm; lower them": coulomb > limit,
        f"the harmonics exceed {limit:g} N or Nm; lower them": np.abs(cogging_mn).max(axis=0) > _OPERAND_MAX,
    }
    for complaint, is_bad in limits.items():
        for axis in np.flatnonzero(is_bad):
            raise InputError(f"{where}: axis {axis + 1}: {complaint}")
    friction_mn = [np.clip(1e3 * c.friction(sign * speed), -_OPERAND_MAX, _OPERAND_MAX) for sign in (1, -1)]
    mu = [sign * np.clip(c.mu * c.ramp(speed) * 2.0**MU_FRACTION, -_OPERAND_MAX, _OPERAND_MAX) for sign in (1, -1)]
    fixed = FixedCompensation(
        friction=np.concatenate([_words(half, last=0) for half in friction_mn], axis=1),
        mu=np.concatenate([_words(half, last=0) for half in mu], axis=1),
        position=_words(cogging_mn, last=cogging_mn[0]),
        phase_step=np.rint(2.0**PHASE_BITS / np.where(c.pitch > 0, pitch_counts, np.inf)).astype(np.int64),
    )
    check_bounds(fixed)
    return fixed


def _words(nodes: np.ndarray, last) -> np.ndarray:
    """Words (n, k, 2) of a table (k, n): each node and the step to the next one; last is the node after the end."""
    codes = np.rint(nodes).astype(np.int64)
    steps = np.diff(codes, axis=0, append=np.broadcast_to(last, (1, codes.shape[1])).astype(np.int64))
    return np.stack([codes.T, steps.T], axis=-1)


def check_bounds(fixed: FixedCompensation) -> None:
    """Assert that no intermediate of gc_compensator can overflow, whatever its inputs: bounds of its intervals.

    Between two nodes a table stays between their values, so its range is that of its nodes. Steps fit as the nodes do:
    friction keeps its sign in a direction, and a wave of at most MAX_HARMONIC per turn changes by less than
    2 pi MAX_HARMONIC / N_POSITIONS < 1 times its largest value (Bernstein's inequality).
    """
    for words in (fixed.friction, fixed.mu, fixed.position):
        assert q.bits_for(int(words.min()), int(words.max())) <= q.OPERAND_BITS
    force_max = 2 ** (q.FORCE_BITS - 1)
    load_max = -(-force_max * int(np.abs(fixed.mu[..., 0]).max()) >> MU_FRACTION) + 1
    friction_max = int(np.abs(fixed.friction[..., 0]).max()) + load_max
    total_max = force_max + int(np.abs(fixed.position[..., 0]).max()) + friction_max
    assert q.bits_for(-friction_max, friction_max) <= FRICTION_BITS
    assert q.bits_for(-total_max, total_max) <= TOTAL_BITS
    assert fixed.phase_step.max() < 2 ** (PHASE_STEP_BITS - 1)
