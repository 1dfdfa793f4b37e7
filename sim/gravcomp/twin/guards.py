"""Clock-accurate twins of what guards gc_safety: parity, clocks, second path to the brakes, their test and read-back.

A class holds the registers of an entity; its attributes are the values before a clock edge, clock() is one rising edge,
at which the inputs have the values that it is given.
"""

from typing import ClassVar

from gravcomp.twin.safety import Timeout


class ParityGuard:
    """gc_parity_guard: upset."""

    def __init__(self) -> None:
        self.upset, self._parity = 0, 0

    def parity(self, load: bool, following: int) -> int:
        """out_parity, from the inputs of this clock."""
        return following.bit_count() % 2 if load else self._parity

    def clock(self, rst: bool, load: bool, following: int, word: int) -> None:
        """One rising edge; word is what the registers hold."""
        self.upset = 0 if rst else self._parity ^ word.bit_count() % 2
        self._parity = self.parity(load, following)


class ClockMonitor:
    """gc_clock_monitor: core_alive and bus_lost. Edges of the two clocks come in any order, but not together."""

    TRIPS = 4

    def __init__(self, bus_limit: int, core_limit: int, stages: int) -> None:
        self._bus_limit, self._core_limit, self._stages = bus_limit, core_limit, stages
        self._sent = self._arrived = False
        self._there, self._back, self._told = ([False] * stages for _ in range(3))
        self._trips, self._bus_time, self._core_time = 0, Timeout(), Timeout()

    @property
    def core_alive(self) -> bool:
        """As many trips in a row were in time as it takes."""
        return self._trips == self.TRIPS

    @property
    def bus_lost(self) -> bool:
        """Too long since the last arrival, or told that the core's clock stood."""
        return self._core_time.expired or not self._told[-1]

    def bus_clock(self, rst: bool) -> None:
        """One rising edge of bus_clk."""
        trip = self._sent == self._back[-1]
        if rst or self._bus_time.expired:
            self._trips = 0
        elif trip:
            self._trips = min(self._trips + 1, self.TRIPS)
        self._bus_time.clock(trip or rst, self._bus_limit)
        self._back = [self._arrived, *self._back[:-1]]
        self._sent ^= trip

    def core_clock(self, rst: bool) -> None:
        """One rising edge of core_clk."""
        arrival = self._there[-1] != self._arrived
        self._core_time.clock(arrival or rst, self._core_limit)
        self._arrived = self._there[-1]
        self._there = [self._sent, *self._there[:-1]]
        self._told = [self.core_alive, *self._told[:-1]]


class BrakePermit:
    """gc_brake_permit: faulty, idle, shut, and brake_engage as a word of one bit per axis."""

    def __init__(self, n_axes: int) -> None:
        self.faulty, self.idle, self.shut = False, True, True
        self._all = (1 << n_axes) - 1
        self.brake_engage, self._last_enable, self._wait = self._all, True, Timeout()

    def clock(
        self,
        rst: bool,
        enable: bool,
        clear: bool,
        fault: bool,
        healthy: bool,
        carried: bool,
        tested: bool,
        test: int,
        brake_clocks: int,
    ) -> None:
        """One rising edge."""
        is_holding = self.shut and not self.idle and not self.faulty
        unsettled = not is_holding or enable != self._last_enable or (enable and not carried)
        contradicts = (not self.shut and self.idle) or (not self.idle and self.faulty)
        faulty, idle, shut = self.faulty, self.idle, self.shut
        if self.faulty:
            faulty = not clear
        elif self.idle:
            idle = not (enable and not self._last_enable and healthy)
        elif not self.shut:
            shut = not enable
        elif self._wait.expired and not unsettled:
            idle, shut = not enable, not (enable and tested)
        faulty = (faulty or fault or contradicts) and not rst
        self.faulty, self.idle, self.shut = faulty, idle or faulty or rst, shut or faulty or rst
        self._wait.clock(unsettled or rst, brake_clocks)
        self._last_enable = enable
        self.brake_engage = self._all if self.idle else self._all & ~test if self.shut else 0


class BrakeTest:
    """gc_brake_test: first, second (words of one bit per axis), done and failed."""

    _NEXT: ClassVar = {(1, 0): (1, 1), (1, 1): (0, 1), (0, 1): (0, 0)}  # first and second path

    def __init__(self, n_axes: int) -> None:
        self.done, self.failed = False, False
        self._n_axes, self._axis, self._paths, self._time = n_axes, None, (0, 0), Timeout()

    @property
    def first(self) -> int:
        """Brakes that the first path releases."""
        return self._paths[0] << (self._axis or 0)

    @property
    def second(self) -> int:
        """Brakes that the second path releases."""
        return self._paths[1] << (self._axis or 0)

    def clock(self, rst: bool, start: bool, feedback: int, clocks: int) -> None:
        """One rising edge."""
        is_idle = self._axis is None
        ends = self._time.expired and not is_idle
        self._time.clock(rst or is_idle or ends, clocks)
        self.failed = start and not rst and ends and feedback != self.first & self.second
        if rst or not start:
            self.done, self._axis, self._paths = False, None, (0, 0)
        elif is_idle and not self.done:
            self._axis, self._paths = 0, (1, 0)
        elif ends and self._paths in self._NEXT:
            self._paths = self._NEXT[self._paths]
        elif ends:
            self.done = self._axis == self._n_axes - 1
            self._axis, self._paths = (None, (0, 0)) if self.done else (self._axis + 1, (1, 0))


class BrakeFeedback:
    """gc_brake_feedback: feedback (a word of one bit per axis) and differs."""

    def __init__(self, n_axes: int, sync_stages: int) -> None:
        self._known, self._pins, self._told = ([0] * sync_stages for _ in range(3))
        self._times = [Timeout() for _ in range(n_axes)]

    @property
    def feedback(self) -> int:
        """The pins, synchronous."""
        return self._pins[-1]

    @property
    def differs(self) -> bool:
        """An axis did not do as it was told for longer than the limit."""
        return any(time.expired for time in self._times)

    def clock(self, rst: bool, pins: int, released: int, clocks: int) -> None:
        """One rising edge."""
        wrong = (self._pins[-1] ^ self._told[-1]) if self._known[-1] else 0
        for axis, time in enumerate(self._times):
            time.clock(rst or not wrong >> axis & 1, clocks)
        self._known = [0] * len(self._known) if rst else [1, *self._known[:-1]]
        self._pins, self._told = [pins, *self._pins[:-1]], [released, *self._told[:-1]]
