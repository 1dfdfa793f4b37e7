"""Clock-accurate twins of gc_brakes and of the entities it is made of.

A class holds the registers of an entity; its attributes are the values before a clock edge, clock() is one rising edge,
at which the inputs have the values that it is given. Sets of axes are words of one bit per axis.
"""

from dataclasses import dataclass
from typing import ClassVar

from gravcomp.facts import State
from gravcomp.twin.timeout import Timeout


class Sequencer:
    """gc_brake_sequencer, a clock at a time: state."""

    def __init__(self) -> None:
        self.state, self._last_enable, self._hold = State.BRAKED, 1, Timeout()

    def _restarts(self, enable: int, reached: bool) -> bool:
        return self.state != State.HOLDING or enable != self._last_enable or (enable == 1 and not reached)

    def may_test(self, enable: int, reached: bool) -> bool:
        """The motors have carried the load: from the inputs of this clock."""
        return self._hold.expired and not self._restarts(enable, reached) and enable == 1

    @property
    def run(self) -> bool:
        """The command is active."""
        return self.state in (State.HOLDING, State.RUN)

    def clock(
        self,
        rst: bool,
        enable: int,
        clear: bool,
        fault: bool,
        healthy: bool,
        reached: bool,
        brake_clocks: int,
        tested: bool = True,
    ) -> None:
        """One rising edge, at which the inputs have these values."""
        restart = self._restarts(enable, reached)
        following = self.state
        if self.state == State.BRAKED and enable > self._last_enable and healthy:
            following = State.HOLDING
        elif self.state == State.HOLDING and self._hold.expired and not restart:
            following = State.BRAKED if not enable else State.RUN if tested else State.HOLDING
        elif self.state == State.RUN and not enable:
            following = State.HOLDING
        elif self.state == State.FAULT and clear:
            following = State.BRAKED
        self._hold.clock(restart or rst, brake_clocks)
        self.state = State.BRAKED if rst else State.FAULT if fault else following
        self._last_enable = enable


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


@dataclass(frozen=True)
class BrakeOptions:
    """The generics of gc_brakes, without their suffix."""

    two_paths: bool = False
    feedback: bool = False
    test: bool = False
    sync_stages: int = 2


class Brakes:
    """gc_brakes: sequencer (state and run), brake_release, brake_engage, feedback and wrong."""

    def __init__(self, n_axes: int, options: BrakeOptions) -> None:
        self._options, self._all, self._in_turn = options, (1 << n_axes) - 1, 0
        self.sequencer, self.brake_release, self.wrong = Sequencer(), 0, False
        self._permit, self._test = BrakePermit(n_axes), BrakeTest(n_axes)
        self._feedback = BrakeFeedback(n_axes, options.sync_stages)

    @property
    def brake_engage(self) -> int:
        """The second path."""
        return self._permit.brake_engage if self._options.two_paths else self._all & ~self.brake_release

    @property
    def feedback(self) -> int:
        """The read-back pins, synchronous."""
        return self._feedback.feedback if self._options.feedback else 0

    def clock(
        self,
        rst: bool,
        enable: int,
        clear: bool,
        fault: bool,
        healthy: bool,
        reached: bool,
        fed: int,
        brake_clocks: int,
        test_clocks: int,
    ) -> None:
        """One rising edge."""
        options, test = self._options, self._test
        first, second, tested = (test.first, test.second, test.done) if options.test else (0, 0, True)
        told, may_test = self.brake_release & ~self.brake_engage, self.sequencer.may_test(enable, reached)
        self.wrong = not rst and (
            (options.two_paths and self._paths_differ())
            or (options.feedback and self._feedback.differs)
            or (options.test and test.failed)
        )  # fmt: skip
        test.clock(rst, may_test, self.feedback, test_clocks)
        self._feedback.clock(rst, fed, told, brake_clocks)
        self._permit.clock(rst, bool(enable), clear, fault, healthy, reached, tested, second, brake_clocks)
        self.sequencer.clock(rst, enable, clear, fault, healthy, reached, brake_clocks, tested)
        in_run, in_holding = self.sequencer.state == State.RUN, self.sequencer.state == State.HOLDING
        self.brake_release = self._all if in_run else first if in_holding else 0
        self._in_turn = first | second

    def _paths_differ(self) -> bool:
        permit, sequencer = self._permit, self.sequencer
        return (
            (self.brake_release ^ permit.brake_engage | self._in_turn) != self._all
            or permit.faulty != (sequencer.state == State.FAULT)
            or permit.shut == (sequencer.state == State.RUN)
            or permit.idle == sequencer.run
        )
