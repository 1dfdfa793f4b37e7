"""What the fixed-point core can ever compute, over all encoder counts, and its distance from the float network."""

from dataclasses import dataclass

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.formats import FixedNetwork, bits_for, partial_sum_interval
from gravcomp.network.weights import Network
from gravcomp.robot.machine import Machine
from gravcomp.twin import network as bittrue
from gravcomp.twin.sin_cos import RADIAN, REST_BITS


@dataclass(frozen=True)
class Interval:
    """Lowest and highest code of a signal over all counts, and the width of its format, bits."""

    low: int
    high: int
    bits: int

    @property
    def needed_bits(self) -> int:
        return bits_for(self.low, self.high)


def intervals(fixed: FixedNetwork) -> dict[str, Interval]:
    """Interval of every signal of the core over ALL encoder counts.

    Interval arithmetic on the constants that the hardware holds, no sampling. A sum's interval holds every partial sum,
    in any order of addition.
    """
    hidden_sum = partial_sum_interval(
        fixed.hidden_weights, fixed.hidden_bias, fixed.x_low, fixed.x_high, fixed.hidden_product_drop
    )
    gamma, h = _activation_intervals(fixed)
    output_sum = partial_sum_interval(fixed.output_weights, fixed.output_bias, *h, fixed.output_product_drop)
    largest_y = 2 ** (fixed.y_bits - 1)
    force = [y * fixed.output_scale >> fixed.output_scale_fraction for y in (-largest_y, largest_y - 1)]
    full_force = 2 ** (q.FORCE_BITS - 1)
    current = [bittrue.current_scaler(np.array(f), fixed) for f in (-full_force, full_force - 1)]
    return {
        **_input_intervals(fixed),
        "x": Interval(int(fixed.x_low.min()), int(fixed.x_high.max()), q.OPERAND_BITS),
        "hidden sum": Interval(*hidden_sum, fixed.hidden_sum_bits),
        **gamma,
        "h": Interval(*h, q.OPERAND_BITS),
        "output sum": Interval(*output_sum, fixed.output_sum_bits),
        "force, mN": Interval(int(force[0].min()), int(force[1].max()), q.FORCE_BITS),
        "current, uA": Interval(int(current[0].min()), int(current[1].max()), q.CURRENT_BITS),
    }


def _activation_intervals(fixed: FixedNetwork) -> tuple[dict[str, Interval], tuple[int, int]]:
    """What Gamma multiplies, and the ends of h."""
    half = 2 ** (q.OPERAND_BITS - 1)
    if fixed.is_lean:
        return {"u of Gamma": Interval(0, half - 1, q.OPERAND_BITS), **_of_square(fixed)}, (-half, half - 1)
    # At a = 0 the slope wraps and its product is 0 all the same; elsewhere |a| >= 1.
    beta = 2 ** (q.SLOPE_FRACTION + 1)
    slope = Interval((beta - half) >> 1, (beta - 1) >> 1, q.OPERAND_BITS)
    # Gamma rises with a over the whole format: its ends are those of a.
    ends = (int(bittrue.activation(np.array(edge))) for edge in (-half, half - 1))
    return {"slope of Gamma": slope}, tuple(ends)


def _of_square(fixed: FixedNetwork) -> dict[str, Interval]:
    """What the serial form adds u^2 up from."""
    if not fixed.is_serial:
        return {}
    quarter, lost = 2 ** (q.OPERAND_BITS - 2), bittrue.lost_bits(fixed)
    return {
        "t of Gamma": Interval(-quarter >> lost, quarter - 1 >> lost, fixed.weight_bits),
        "sum of the square": Interval(*bittrue.serial_square_interval(fixed), fixed.output_sum_bits),
    }


def _input_intervals(fixed: FixedNetwork) -> dict[str, Interval]:
    """What comes before x, of positions and of axes that turn."""
    found, is_turning = {}, fixed.is_turning
    if not is_turning.all():
        low, high = ((end >> fixed.count_shift)[~is_turning] for end in (fixed.count_low, fixed.count_high))
        found["count code"] = Interval(int(low.min()), int(high.max()), q.OPERAND_BITS)
    if is_turning.any():
        rest = 2 ** (REST_BITS - 1)
        found["turn beside its place, rad"] = Interval(-rest * RADIAN, rest * RADIAN, q.OPERAND_BITS)
    return found


def fixed_point_error_mn(network: Network, fixed: FixedNetwork, machine: Machine, n_poses: int, seed: int):
    """Forces of the core less those of the float network at exact positions, mN, (n_poses, n), over the workspace."""
    q = machine.robot.workspace(n_poses, seed)
    return bittrue.core(machine.drive.counts(q), fixed).force_mn - 1000.0 * network.forces(q)
