"""Stimuli of gc_safety: nothing speaks against motion, or one cause does; the RTL beside its twin."""

import os

import numpy as np

from codes import fixed_network, pack_rows, unpack
from gravcomp.core.formats import COUNT_BITS
from gravcomp.twin.brakes import BrakeOptions, State
from gravcomp.twin.safety import Cause, safety
from playback import flush, play

BRAKES = ("brake_release", "brake_engage", "sts_feedback")
OUTPUTS = ("run", *BRAKES, "sts_state", "sts_present", "sts_fault", "sts_first_cause", "sts_first_count", "sts_events")
PERIOD_BITS = 32
WIDTHS = {name: COUNT_BITS for name in ("in_count", "cfg_count_low", "cfg_count_high")} | {
    "in_period": PERIOD_BITS,
    "cfg_period_min": PERIOD_BITS - 1,
    **{f"in_{name}": 1 for name in ("referenced", "illegal", "clamped", "saturated", "reached", "deviates", "astray")},
}
STILL = 2**31 - 1  # speed_period at standstill
SHORTEST = 8  # speed_period at the limit speed of the decoder
PERIOD_MIN, SATURATION, WATCHDOG, RESULT, BRAKE, COMMAND, HOLD = 100, 20, 40, 30, 10, 15, 50
LIMITS = {
    Cause.SATURATION: SATURATION,
    Cause.WATCHDOG: WATCHDOG,
    Cause.RESULT: RESULT,
    Cause.COMMAND: COMMAND,
    Cause.HOLD: HOLD,
    Cause.BRAKE: BRAKE,
}
# In these states only, which they end: nothing of them lasts.
WHILE = {Cause.COMMAND: State.RUN, Cause.HOLD: State.HOLDING}
GUARDED = {"two_paths_g": "true", "brake_feedback_g": "true", "guard_g": "true"}
ALL = (1 << len(Cause)) - 1
ENABLED, RUNNING, ONSET = 10, 40, 100  # clocks of the directed tests


def quiet_inputs(n_clocks: int) -> dict[str, np.ndarray]:
    """Nothing speaks against motion: referenced, still, within limits, a kick and a result every eighth clock."""
    n_axes = fixed_network().n_axes
    zero, axes_zero = np.zeros(n_clocks, np.int64), np.zeros((n_clocks, n_axes), np.int64)
    pulses = (np.arange(n_clocks) % 8 == 0).astype(np.int64)
    names = ("rst", "enable", "clear", "in_crc_bad", "in_rom_bad", "in_clock_bad", "in_core_bad", "in_upset")
    inputs = {name: zero for name in (*names, "cfg_test_clocks")}
    inputs |= {"estop_n": zero + 1, "kick": pulses, "in_result": pulses}
    names = ("in_illegal", "in_clamped", "in_saturated", "in_deviates", "in_astray", "brake_fails")
    inputs |= {name: axes_zero for name in names}
    inputs |= {"in_referenced": axes_zero + 1, "in_reached": axes_zero + 1, "in_period": axes_zero + STILL}
    low, high = position_window()
    room = (high - low) // 4
    moving = 7 * np.arange(n_clocks)[:, None] % room + np.minimum(1000 * np.arange(n_axes), room)
    inputs |= {"in_count": (low + high) // 2 + moving}
    inputs |= {"cfg_count_low": axes_zero + low, "cfg_count_high": axes_zero + high}
    limits = {"saturation_clocks": SATURATION, "watchdog_clocks": WATCHDOG}
    limits |= {"result_clocks": RESULT, "brake_clocks": BRAKE, "command_clocks": COMMAND, "hold_clocks": HOLD}
    inputs |= {f"cfg_{name}": zero + value for name, value in limits.items()}
    inputs["cfg_period_min"] = axes_zero + PERIOD_MIN
    return {name: values.copy() for name, values in inputs.items()}


def position_window() -> np.ndarray:
    """Lowest and highest count of each axis that is no fault: the trained range and 2 mm beyond."""
    fixed = fixed_network()
    return np.array([fixed.count_low - 2000, fixed.count_high + 2000])


def present_it(inputs: dict[str, np.ndarray], cause: Cause, clocks: slice, axis: int) -> None:
    """Makes the cause happen in those clocks, on that axis where it has one. A time-out: the clocks of silence."""
    low, high = position_window()
    name, value = {
        Cause.ESTOP: ("estop_n", 0),
        Cause.ENCODER: ("in_illegal", 1),
        Cause.CRC: ("in_crc_bad", 1),
        Cause.ROM: ("in_rom_bad", 1),
        Cause.SPEED: ("in_period", (PERIOD_MIN - 1) * (1 - 2 * (axis % 2))),
        Cause.POSITION: ("in_count", high[axis] + 1 if axis % 2 else low[axis] - 1),
        Cause.SATURATION: ("in_saturated" if axis % 2 else "in_clamped", 1),
        Cause.WATCHDOG: ("kick", 0),
        Cause.RESULT: ("in_result", 0),
        Cause.UNREFERENCED: ("in_referenced", 0),
        Cause.COMMAND: ("in_deviates", 1),
        Cause.HOLD: ("in_reached", 0),
        Cause.BRAKE: ("brake_fails", 1),
        Cause.CLOCK: ("in_clock_bad", 1),
        Cause.CORE: ("in_core_bad", 1),
        Cause.UPSET: ("in_upset", 1),
        Cause.FOLLOWING: ("in_astray", 1),
    }[cause]
    inputs[name][(clocks, axis) if inputs[name].ndim == 2 else clocks] = value


async def run_and_compare(dut, inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Outputs of the RTL, codes unsigned and axes apart, after they were found equal to the twin's.

    The read-back of a brake follows at once what the brake is told, but on axes and in clocks with brake_fails.
    """
    inputs, fails = dict(inputs), inputs["brake_fails"] @ (1 << np.arange(inputs["brake_fails"].shape[1]))
    del inputs["brake_fails"]
    options = BrakeOptions(two_paths=True, feedback=True, sync_stages=int(os.environ["SYNC_STAGES_G"]))
    expected = safety(inputs, options, lambda told, k: told ^ int(fails[k]))
    inputs["brake_fed"] = expected["brake_fed"]
    packed = {name: pack_rows(values, WIDTHS[name]) if name in WIDTHS else values for name, values in inputs.items()}
    await flush(dut, 4, brake_fed=0, enable=1)
    got = await play(dut, packed, OUTPUTS)
    n_axes = inputs["in_count"].shape[1]
    for name in (*BRAKES, "sts_state", "sts_present", "sts_fault", "sts_first_cause", "sts_events"):
        got[name] &= (1 << len(getattr(dut, name))) - 1
    assert set(got["brake_release"].tolist()) <= {0, 2**n_axes - 1}, "the brakes of all axes move together"
    got["sts_first_count"] = unpack(got["sts_first_count"], COUNT_BITS, n_axes)
    for name in OUTPUTS:
        np.testing.assert_array_equal(got[name], expected[name], err_msg=name)
    return got
