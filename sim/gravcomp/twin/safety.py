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
    chain, n_clocks = _Chain(inputs["in_count"].shape[1], options), len(present)
    fed = np.zeros_like(present) if brake else inputs["brake_fed"]
    rows = [chain.outputs()]
    for k in range(n_clocks - 1):
        at = {name: values[k] for name, values in inputs.items()}
        present[k] |= chain.present
        if brake:
            fed[k] = brake(chain.told, k)
        chain.clock(at, int(present[k]), known[k] == 1, int(fed[k]))
        rows.append(chain.outputs())
    present[-1] |= chain.present
    out = {name: np.array([row[name] for row in rows], np.int64) for name in rows[0]}
    return out | {"sts_present": present, "brake_fed": fed}


class _Chain:
    """What of gc_safety has a state, a clock at a time, with the causes that depend on it."""

    def __init__(self, n_axes: int, options: BrakeOptions) -> None:
        self._brakes, self._latch, self._load = Brakes(n_axes, options), FaultLatch(), _Load()
        self._count_1 = np.zeros(n_axes, np.int64)

    @property
    def present(self) -> int:
        """Causes, of the load and the brakes."""
        return self._load.present(self._brakes.sequencer.state) | self._brakes.wrong << Cause.BRAKE

    @property
    def told(self) -> int:
        """Brakes that both paths tell to open."""
        return self._brakes.brake_release & ~self._brakes.brake_engage

    def outputs(self) -> dict[str, int | np.ndarray]:
        """By port name."""
        brakes, latch = self._brakes, self._latch
        return {
            "run": brakes.sequencer.run,
            "brake_release": brakes.brake_release,
            "brake_engage": brakes.brake_engage,
            "sts_feedback": brakes.feedback,
            "sts_state": brakes.sequencer.state,
            "sts_fault": latch.causes,
            "sts_first_cause": latch.first_cause,
            "sts_first_count": np.broadcast_to(latch.first_count, self._count_1.shape),
            "sts_events": latch.events,
        }

    def clock(self, inputs: Mapping[str, np.ndarray], present: int, is_known: bool, fed: int) -> None:
        """One rising edge, at which the inputs, the causes and the brakes' read-back have these values.

        is_known: of the emergency stop, whose synchroniser is full.
        """
        state, rst, clear = self._brakes.sequencer.state, bool(inputs["rst"]), int(inputs["clear"])
        self._load.clock(inputs, state)
        fault = present & (ALWAYS if state == State.BRAKED else ~0)
        cleared = clear != 0 and not self._latch.causes & ~clear
        self._latch.clock(rst, clear, fault, self._count_1)
        self._brakes.clock(
            rst,
            int(inputs["enable"]),
            cleared,
            fault != 0,
            present == 0 and is_known,
            bool(inputs["in_reached"].all()),
            fed,
            int(inputs["cfg_brake_clocks"]),
            int(inputs["cfg_test_clocks"]),
        )
        self._count_1 = inputs["in_count"]


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
    period_min = np.concatenate((np.zeros_like(period[:2]), inputs["cfg_period_min"][:-2]))
    limit = np.where(period_min == 0, NO_PERIOD, np.maximum(period_min, period_shortest + 1))
    low, high = inputs["cfg_count_low"], inputs["cfg_count_high"]
    flags = (
        (inputs["in_illegal"].any(axis=1)) << Cause.ENCODER
        | (inputs["in_crc_bad"] != 0) << Cause.CRC
        | (inputs["in_rom_bad"] != 0) << Cause.ROM
        | (inputs["in_clock_bad"] != 0) << Cause.CLOCK
        | (inputs["in_core_bad"] != 0) << Cause.CORE
        | (inputs["in_upset"] != 0) << Cause.UPSET
        | (inputs["in_astray"].any(axis=1)) << Cause.FOLLOWING
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
        self.events = (self.events + (fault & ~self.causes != 0)) % 256
        if not self.causes and fault:
            self.first_cause, self.first_count = fault, count
        self.causes = self.causes & ~clear | fault
        if not self.causes:
            self.first_cause = 0
