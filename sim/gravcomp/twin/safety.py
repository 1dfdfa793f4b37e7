"""Clock-accurate twin of gc_safety and of the entities it is made of, one function each.

Element k of an array is the value just before rising clock edge k, as in gravcomp.twin.encoder.
"""

from collections.abc import Callable, Mapping

import numpy as np

from gravcomp.facts import ALWAYS, Cause, State
from gravcomp.twin.brakes import BrakeOptions, Brakes
from gravcomp.twin.encoder import NO_PERIOD, DecoderConfig, synchronizer
from gravcomp.twin.timeout import Timeout, timeout


def safety(
    inputs: Mapping[str, np.ndarray],
    options: BrakeOptions,
    brake: Callable[[int, int], int] | None = None,
    period_shortest: int = DecoderConfig().shortest_period,
) -> dict[str, np.ndarray]:
    """gc_safety: its outputs by port name, from all its inputs but clk by port name.

    Inputs of several axes and sts_first_count are (clocks, axes), all others (clocks,); brake_fed and what the brakes
    are told are words of one bit per axis. brake(told, clock): brake_fed of that clock, from the brakes that are told
    to be open, in place of the input. The outputs have brake_fed, too.
    """
    known, estop_n = synchronizer(inputs["rst"], inputs["estop_n"], options.sync_stages)
    present = _present(inputs, period_shortest) | (known & ~estop_n & 1) << Cause.ESTOP
    names = (
        "run",
        "brake_release",
        "brake_engage",
        "sts_feedback",
        "sts_state",
        "sts_fault",
        "sts_first_cause",
        "sts_events",
    )
    out = {name: np.zeros_like(present) for name in names} | {"sts_present": present}
    out["sts_first_count"], n_axes = np.zeros_like(inputs["in_count"]), inputs["in_count"].shape[1]
    brakes, latch, count_1 = Brakes(n_axes, options), FaultLatch(), np.zeros_like(inputs["in_count"][0])
    out["brake_engage"][0], sequencer = brakes.brake_engage, brakes.sequencer
    load, fed = _Load(), np.zeros_like(present) if brake else inputs["brake_fed"]
    out["brake_fed"] = fed
    for k in range(len(present) - 1):
        present[k] |= load.present(sequencer.state) | brakes.wrong << Cause.BRAKE
        load.clock({name: values[k] for name, values in inputs.items()}, sequencer.state)
        if brake:
            fed[k] = brake(brakes.brake_release & ~brakes.brake_engage, k)
        fault = int(present[k]) & (ALWAYS if sequencer.state == State.BRAKED else ~0)
        clear = int(inputs["clear"][k])
        cleared = clear != 0 and not latch.causes & ~clear
        latch.clock(bool(inputs["rst"][k]), clear, fault, count_1)
        brakes.clock(
            bool(inputs["rst"][k]),
            int(inputs["enable"][k]),
            cleared,
            fault != 0,
            present[k] == 0 and known[k] == 1,
            bool(inputs["in_reached"][k].all()),
            int(fed[k]),
            *(int(inputs[name][k]) for name in ("cfg_brake_clocks", "cfg_test_clocks")),
        )
        count_1 = inputs["in_count"][k]
        out["sts_state"][k + 1] = sequencer.state
        out["run"][k + 1], out["sts_feedback"][k + 1] = sequencer.run, brakes.feedback
        out["brake_release"][k + 1], out["brake_engage"][k + 1] = brakes.brake_release, brakes.brake_engage
        out["sts_fault"][k + 1], out["sts_first_cause"][k + 1] = latch.causes, latch.first_cause
        out["sts_first_count"][k + 1], out["sts_events"][k + 1] = latch.first_count, latch.events
    present[-1] |= load.present(sequencer.state) | brakes.wrong << Cause.BRAKE
    return out


class _Load:
    """Whether the motors carry the load, a clock at a time: the causes that depend on the state."""

    def __init__(self) -> None:
        self._command, self._hold = Timeout(), Timeout()

    def present(self, state: State) -> int:
        hold = self._hold.expired and state != State.RUN
        return self._command.expired << Cause.COMMAND | hold << Cause.HOLD

    def clock(self, inputs: Mapping[str, np.ndarray], state: State) -> None:
        """One rising edge, at which the inputs and the state have these values."""
        deviates = state == State.RUN and inputs["in_deviates"].any()
        holds = state == State.HOLDING and inputs["enable"]
        self._command.clock(bool(inputs["rst"] or not deviates), int(inputs["cfg_command_clocks"]))
        self._hold.clock(bool(inputs["rst"] or not holds), int(inputs["cfg_hold_clocks"]))


def _present(inputs: Mapping[str, np.ndarray], period_shortest: int) -> np.ndarray:
    """All causes but the emergency stop and those of the load, one clock after they are at the inputs."""
    rst = inputs["rst"] != 0
    count, period = inputs["in_count"], inputs["in_period"]
    period_min = np.concatenate((np.zeros_like(period[:1]), inputs["cfg_period_min"][:-1]))
    limit = np.where(period_min == 0, NO_PERIOD, np.maximum(period_min, period_shortest + 1))
    low, high = inputs["cfg_count_low"], inputs["cfg_count_high"]
    flags = (
        (inputs["in_illegal"].any(axis=1)) << Cause.ENCODER
        | (inputs["in_crc_bad"] != 0) << Cause.CRC
        | (inputs["in_rom_bad"] != 0) << Cause.ROM
        | (inputs["in_clock_bad"] != 0) << Cause.CLOCK
        | (inputs["in_core_bad"] != 0) << Cause.CORE
        | (inputs["in_upset"] != 0) << Cause.UPSET
        | (np.abs(period) < limit).any(axis=1) << Cause.SPEED
        | ((count < low) | (count > high)).any(axis=1) << Cause.POSITION
        | (~inputs["in_referenced"].all(axis=1)) << Cause.UNREFERENCED
    ).astype(np.int64)
    flags[rst] = 0
    is_saturated = inputs["in_saturated"].any(axis=1) | inputs["in_clamped"].any(axis=1)
    return (
        np.concatenate(([0], flags[:-1]))
        | timeout(rst | ~is_saturated, inputs["cfg_saturation_clocks"]) << Cause.SATURATION
        | timeout(rst | (inputs["kick"] != 0), inputs["cfg_watchdog_clocks"]) << Cause.WATCHDOG
        | timeout(rst | (inputs["in_result"] != 0), inputs["cfg_result_clocks"]) << Cause.RESULT
    )


class FaultLatch:
    """gc_fault_latch, a clock at a time: causes that were not cleared yet, first_cause, first_count and events."""

    def __init__(self) -> None:
        self.causes = self.first_cause = self.events = 0
        self.first_count: np.ndarray | int = 0

    def clock(self, rst: bool, clear: int, fault: int, count: np.ndarray) -> None:
        """One rising edge, at which the inputs have these values."""
        if rst:
            self.__init__()
            return
        self.events = (self.events + ((self.causes & ~clear | fault) & ~self.causes != 0)) % 256
        if not self.causes and fault:
            self.first_cause, self.first_count = fault, count
        self.causes = self.causes & ~clear | fault
        if not self.causes:
            self.first_cause = 0
