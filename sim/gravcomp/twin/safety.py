"""Clock-accurate twin of gc_safety and of the entities it is made of, one function each.

Element k of an array is the value just before rising clock edge k, as in gravcomp.twin.encoder.
"""

from collections.abc import Mapping
from enum import IntEnum

import numpy as np

from gravcomp.twin.encoder import NO_PERIOD, DecoderConfig, synchronizer


class State(IntEnum):
    """Codes of gc_safety_pkg."""

    BRAKED = 0b000
    HOLDING = 0b011
    RUN = 0b101
    FAULT = 0b110


class Cause(IntEnum):
    """Bits of gc_safety_pkg."""

    ESTOP = 0
    ENCODER = 1
    CRC = 2
    ROM = 3
    SPEED = 4
    POSITION = 5
    SATURATION = 6
    WATCHDOG = 7
    RESULT = 8
    REFERENCE = 9
    COMMAND = 10
    HOLD = 11

    @property
    def mask(self) -> int:
        """The cause in a register of causes."""
        return 1 << self


ALWAYS = Cause.ESTOP.mask | Cause.ENCODER.mask | Cause.CRC.mask | Cause.ROM.mask  # faults while braked, too


class Timeout:
    """gc_timeout, a clock at a time: expired."""

    def __init__(self) -> None:
        self.expired, self._quiet = False, 0

    def clock(self, restart: bool, limit: int) -> None:
        """One rising edge, at which the inputs have these values; reset is a restart."""
        self.expired = not restart and self._quiet >= limit
        if restart:
            self._quiet = 0
        elif self._quiet < limit:
            self._quiet += 1


def timeout(restart: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """gc_timeout: expired, from restart (or reset) and limit."""
    expired, counter = np.zeros(len(restart), np.int64), Timeout()
    for k in range(len(restart) - 1):
        counter.clock(bool(restart[k]), int(limit[k]))
        expired[k + 1] = counter.expired
    return expired


def safety(
    inputs: Mapping[str, np.ndarray], sync_stages: int = 2, period_shortest: int = DecoderConfig().shortest_period
) -> dict[str, np.ndarray]:
    """gc_safety: its outputs by port name, from all its inputs but clk by port name.

    Inputs of several axes and sts_first_count are (clocks, axes), all others (clocks,).
    """
    known, estop_n = synchronizer(inputs["rst"], inputs["estop_n"], sync_stages)
    present = _present(inputs, period_shortest) | (known & ~estop_n & 1) << Cause.ESTOP
    names = ("run", "brake_release", "sts_state", "sts_fault", "sts_first_cause", "sts_events")
    out = {name: np.zeros_like(present) for name in names} | {"sts_present": present}
    out["sts_first_count"] = np.zeros_like(inputs["in_count"])
    sequencer, latch, count_1 = Sequencer(), FaultLatch(), np.zeros_like(inputs["in_count"][0])
    load = _Load()
    for k in range(len(present) - 1):
        present[k] |= load.present(sequencer.state)
        load.clock({name: values[k] for name, values in inputs.items()}, sequencer.state)
        fault = int(present[k]) & (ALWAYS if sequencer.state == State.BRAKED else ~0)
        clear = int(inputs["clear"][k])
        cleared = clear != 0 and not latch.causes & ~clear
        latch.clock(bool(inputs["rst"][k]), clear, fault, count_1)
        sequencer.clock(
            bool(inputs["rst"][k]),
            int(inputs["enable"][k]),
            cleared,
            fault != 0,
            present[k] == 0 and known[k] == 1,
            bool(inputs["in_reached"][k].all()),
            int(inputs["cfg_brake_clocks"][k]),
        )
        count_1 = inputs["in_count"][k]
        out["sts_state"][k + 1] = sequencer.state
        out["run"][k + 1] = sequencer.state in (State.HOLDING, State.RUN)
        out["brake_release"][k + 1] = sequencer.state == State.RUN
        out["sts_fault"][k + 1], out["sts_first_cause"][k + 1] = latch.causes, latch.first_cause
        out["sts_first_count"][k + 1], out["sts_events"][k + 1] = latch.first_count, latch.events
    present[-1] |= load.present(sequencer.state)
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
    period_min = np.concatenate(([0], inputs["cfg_period_min"][:-1]))
    limit = np.where(period_min == 0, NO_PERIOD, np.maximum(period_min, period_shortest + 1))
    low, high = inputs["cfg_count_low"], inputs["cfg_count_high"]
    flags = (
        (inputs["in_illegal"].any(axis=1)) << Cause.ENCODER
        | (inputs["in_crc_bad"] != 0) << Cause.CRC
        | (inputs["in_rom_bad"] != 0) << Cause.ROM
        | (np.abs(period) < limit[:, None]).any(axis=1) << Cause.SPEED
        | ((count < low) | (count > high)).any(axis=1) << Cause.POSITION
        | (~inputs["in_referenced"].all(axis=1)) << Cause.REFERENCE
    ).astype(np.int64)
    flags[rst] = 0
    is_saturated = inputs["in_saturated"].any(axis=1) | inputs["in_clamped"].any(axis=1)
    return (
        np.concatenate(([0], flags[:-1]))
        | timeout(rst | ~is_saturated, inputs["cfg_saturation_clocks"]) << Cause.SATURATION
        | timeout(rst | (inputs["kick"] != 0), inputs["cfg_watchdog_clocks"]) << Cause.WATCHDOG
        | timeout(rst | (inputs["in_result"] != 0), inputs["cfg_result_clocks"]) << Cause.RESULT
    )


class Sequencer:
    """gc_brake_sequencer, a clock at a time: state."""

    def __init__(self) -> None:
        self.state, self._last_enable, self._hold = State.BRAKED, 1, Timeout()

    def clock(
        self, rst: bool, enable: int, clear: bool, fault: bool, healthy: bool, reached: bool, brake_clocks: int
    ) -> None:
        """One rising edge, at which the inputs have these values."""
        restart = self.state != State.HOLDING or enable != self._last_enable or (enable == 1 and not reached)
        following = self.state
        if self.state == State.BRAKED and enable > self._last_enable and healthy:
            following = State.HOLDING
        elif self.state == State.HOLDING and self._hold.expired and not restart:
            following = State.RUN if enable else State.BRAKED
        elif self.state == State.RUN and not enable:
            following = State.HOLDING
        elif self.state == State.FAULT and clear:
            following = State.BRAKED
        self._hold.clock(restart or rst, brake_clocks)
        self.state = State.BRAKED if rst else State.FAULT if fault else following
        self._last_enable = enable


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
