"""One sitting: the brakes are released, the steps of a route are measured one by one, the brakes are engaged.

The fabric's servo moves and holds, its recorder takes means over ticks; the host names targets. At a hold the first
record after the robot has settled is thrown away, as it began before; those that follow are kept.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from gravcomp.campaign.journal import Journal
from gravcomp.campaign.route import HOLD, Step, longest_way
from gravcomp.driver.host import State
from gravcomp.driver.moving import Mover
from gravcomp.logs.records import Records, records_of
from gravcomp.robot.machine import Machine
from gravcomp.twin.recorder import words_of

RECORD_S = 0.06  # of a record, at least
RECORDS_OF_HOLD = 2  # per approach: the spread of two is the noise
LEAST_MOVE_S = 0.2
_SETTLING_S = 0.25
_AT_REST = 2  # records at either end of a leg


class Sitting:
    """Measures steps with a Mover and keeps them in a journal. check is called often: what it raises ends the sitting.

    slow: counts per second of the axis that goes farthest, on average, in approaches and legs; travel is as fast as the
    limits of the setpoint allow.
    """

    def __init__(self, mover: Mover, journal: Journal, machine: Machine, slow: float, check: Callable[[State], None]):
        self.mover, self.journal, self.machine, self.slow, self.check = mover, journal, machine, slow, check
        self._per_count = machine.drive.unit_per_count
        self._states: Iterator[State] = iter(())

    def measure(self, phase: str, steps: Mapping[int, Step], first: Callable[[], None]) -> Iterator[Step]:
        """Measure those steps of a phase, by their number in the route, that are not in the journal; each step when it
        is. first is called once the robot is held. Raises InputError as Mover.go does; the brakes are engaged whatever
        ends it.
        """
        mover, left = self.mover, sorted(set(steps) - self.journal.done(phase))
        if not left:
            return
        mover.check([target for step in steps.values() for target in (step.pose, *step.ends)])
        mover.motion.configure(mover.gains)
        self._states = mover.board.hold(mover.limits)
        try:
            self.check(next(self._states))
            first()
            mover.begin_records(mover.power_of_ticks(RECORD_S))
            for number in left:
                measure = self._hold if steps[number].kind == HOLD else self._leg
                self.journal.add(phase, number, *measure(steps[number]))
                yield steps[number]
        finally:
            self._states.close()

    def _hold(self, step: Step) -> tuple[list[list[int]], np.ndarray]:
        """Records of a pose from the ends of its approaches, and their approach velocities."""
        words, velocities = [], []
        for end in step.ends:
            self._go(end, 0.0)
            seconds = step.seconds or self._slowly(end, step.pose)
            self._go(step.pose, seconds)
            self._see(self.mover.hold(self._states, _SETTLING_S))
            words += self._records(1 + RECORDS_OF_HOLD)[1:]
            way = np.subtract(step.pose, end) * self._per_count
            velocities += [way / seconds] * RECORDS_OF_HOLD
        return words, np.array(velocities)

    def _leg(self, step: Step) -> tuple[list[list[int]], np.ndarray]:
        """Records of a leg there and back, less those that began or ended at rest, and the velocities in them."""
        self._go(step.ends[0], 0.0)
        self._see(self.mover.hold(self._states, _SETTLING_S))
        words, velocities = [], []
        for start, end in (step.ends, step.ends[::-1]):
            self.mover.taken()
            self._go(end, step.seconds or self._slowly(start, end))
            taken = self.mover.taken()
            own, records = self._split(taken), records_of(taken, self.machine.n_axes)
            moving = slice(_AT_REST, len(own) - _AT_REST)
            words += own[moving]
            velocities.append(self._velocity(records)[moving])
            self._see(self.mover.hold(self._states, _SETTLING_S))
        return words, np.concatenate(velocities)

    def _velocity(self, records: Records) -> np.ndarray:
        """m/s or rad/s (k, n) from the mean counts before and after each record."""
        t_s = records.tick * self.mover.tick_s
        return np.gradient(records.count * self._per_count, t_s, axis=0)

    def _slowly(self, start: Sequence[int], end: Sequence[int]) -> float:
        return max(longest_way(start, end) / self.slow, LEAST_MOVE_S)

    def _go(self, target: Sequence[int], seconds: float) -> None:
        self._see(self.mover.move(self._states, target, seconds))

    def _records(self, n: int) -> list[list[int]]:
        """The next n records that are complete."""
        self.mover.taken()
        words: list[list[int]] = []
        while len(words) < n:
            self.check(self.mover.round(self._states))
            words += self._split(self.mover.taken())
        return words[:n]

    def _split(self, words: list[int]) -> list[list[int]]:
        size = words_of(self.machine.n_axes)
        return [words[first : first + size] for first in range(0, len(words), size)]

    def _see(self, states: Iterator[State]) -> None:
        for state in states:
            self.check(state)
