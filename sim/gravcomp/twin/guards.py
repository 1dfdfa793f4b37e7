"""Clock-accurate twins of what guards registers and clocks: gc_parity_guard and gc_clock_monitor.

A class holds the registers of an entity; its attributes are the values before a clock edge, clock() is one rising edge,
at which the inputs have the values that it is given.
"""

from gravcomp.twin.timeout import Timeout


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
        self._was_alive = False
        self._trips, self._bus_time, self._core_time = 0, Timeout(), Timeout()

    @property
    def core_alive(self) -> bool:
        """As many trips in a row were in time as it takes."""
        return self._trips == self.TRIPS

    @property
    def bus_lost(self) -> bool:
        """Too long since the last arrival, or told that the core's clock stood."""
        return self._core_time.expired or (self._was_alive and not self._told[-1])

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
        self._was_alive = not rst and (self._was_alive or self._told[-1])
        self._told = [self.core_alive, *self._told[:-1]]
