"""A robot in the physics engine at the pins of a core in a library: its registers are a Bus for gravcomp.driver.

Motors exert what the core commands, brakes that are engaged hold everything, encoders go where the axes went, drives
tell their currents with noise: a step of the physics, a millisecond, has as many clocks of the core as its clock_hz
says. Time passes while registers are read and written, and only then.
"""

import ctypes
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gravcomp.driver.serial_bus import Refused
from gravcomp.errors import InputError
from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.prototype.imperfections import Imperfection
from gravcomp.prototype.plant import MakeImperfections, Plant
from gravcomp.robot.machine import Machine
from gravcomp_lab.cosim.library import EDGE_CLOCKS, Port

_INDEX, _START = 2, -40  # counts from the middle of an axis: its only mark, and where it stands when power comes on
_CARRY_COUNTS = 30  # and elsewhere, of the axis that goes farthest
_EXCHANGES_PER_STEP = 2  # a USB bridge takes half a millisecond at least
_PATIENCE_CLOCKS = 10_000  # of an access
NOISE_N = 0.5  # of a single measured current, as an effort of the Sphe.I.Ro.


def middles(machine: Machine) -> np.ndarray:
    """Counts (n,) near the middles of the axes, where all encoder pins are low."""
    return 4 * np.rint(machine.drive.counts(np.array([(a.low + a.high) / 2 for a in machine.axes])) / 4).astype(int)


class World:
    """A Bus, with a robot behind it. steps: milliseconds so far; engaged: how often the brakes fell while they held.

    effects: what the robot has and its model lacks. hand_counts: that a hand moves the axes in a step over an index.
    Raises InputError when the library cannot be loaded.
    """

    hand_counts = 2

    def __init__(
        self, library: Path, machine: Machine, effects: Sequence[Imperfection] | MakeImperfections = (), seed: int = 0
    ):
        self.line, self.sent, self.repeated = f"simulated {machine.name}", 0, 0
        self.machine, self.plant, self.steps, self.engaged = machine, Plant(machine, effects), 0, 0
        self.step_clocks = round(machine.clock_hz * TIME_STEP_S)
        self._rng = np.random.default_rng([seed, 31])
        self._noise_ua = 1e6 * NOISE_N * self.plant.sizes.effort / machine.drive.effort_per_ampere
        self._per_ua = 1e-6 * machine.drive.effort_per_ampere
        n, self.index, self._start = machine.n_axes, middles(machine) + _INDEX, middles(machine) + _START
        self.plant.place(machine.drive.positions(self._start), np.zeros(n), 0.0)
        self.plant.engine.data.qvel[:] = 0.0
        self._way: list[list[int]] = []  # counts on which someone takes the robot, the last first
        self._was_released = False
        try:
            self._core = ctypes.CDLL(str(library.resolve()))
        except OSError as error:
            raise InputError(f"{library}: cannot be loaded ({error}); build it again") from None
        self._core.cosim_open.restype = ctypes.POINTER(Port)
        axes = ctypes.c_int32 * n
        opened = self._core.cosim_open(n, self.step_clocks, axes(*self._start.tolist()), axes(*self.index.tolist()))
        self.port: Port = opened.contents

    def close(self) -> None:
        self._core.cosim_close()

    def now_s(self) -> float:
        """The robot's time."""
        return self.steps * TIME_STEP_S

    def read(self, offset: int) -> int:
        return self.read_run(offset, 1)[0]

    def write(self, offset: int, word: int) -> None:
        self.write_run(offset, [word])

    def read_run(self, offset: int, n_words: int) -> list[int]:
        """So many registers from an offset on, in one exchange."""
        self._exchange()
        return [self._access(0, offset + 4 * k, 0) for k in range(n_words)]

    def write_run(self, offset: int, words: Sequence[int]) -> None:
        """Registers from an offset on, in one exchange."""
        self._exchange()
        for k, word in enumerate(words):
            self._access(1, offset + 4 * k, word)

    def _exchange(self) -> None:
        """The time of a frame and its answer, but for the accesses themselves."""
        self.sent += 1
        end = self.port.clock + self.step_clocks // _EXCHANGES_PER_STEP
        while self.port.clock < end:
            self._run(end - self.port.clock)

    def _access(self, is_write: int, offset: int, word: int) -> int:
        self._core.cosim_begin(is_write, offset, word)
        end = self.port.clock + _PATIENCE_CLOCKS
        while self._run(0):
            if self.port.clock > end:
                raise InputError(f"{self.line}: no answer")
        if self.port.error:
            raise Refused(f"{self.line}: {'write' if is_write else 'read'} at 0x{offset:03X} is refused", 4)
        return self.port.data

    def _run(self, clocks: int) -> int:
        """So many clocks, or with 0 until the access has ended, but no longer than to the end of this step; whether an
        access is under way.
        """
        is_busy = self._core.cosim_run(clocks)
        if self.port.step_clock == 0:
            self._step()
        return is_busy

    def wait(self, steps: int) -> None:
        """So many milliseconds without a host."""
        for _ in range(steps):
            self._run(self.step_clocks)

    def by_hand(self) -> None:
        """Someone moves every axis over its index and back."""
        there = np.arange(0, -2 * _START, self.hand_counts)
        self._follow(np.concatenate([there, there[::-1]])[:, None] + self._start)

    def carry(self, counts: np.ndarray) -> None:
        """Someone carries the robot, whose brakes are engaged, straight to other counts (n,)."""
        here = np.array(self.port.position[: self.machine.n_axes])
        steps = int(np.abs(counts - here).max()) // _CARRY_COUNTS + 2
        self._follow(np.rint(np.linspace(here, counts, steps)))

    def _follow(self, ways: np.ndarray) -> None:
        """Along counts (k, n), a step each; the physics has the robot again at the end."""
        self._way = ways.astype(int).tolist()[::-1]
        while self._way:
            self.wait(1)
        self._put(ways[-1])

    def _put(self, counts: np.ndarray) -> None:
        """The physics has the axes at rest at counts (n,)."""
        q = self.machine.drive.positions(counts)
        self.plant.place(q, np.zeros(self.machine.n_axes), self.plant.state.t_s)
        self.plant.engine.data.qvel[:] = 0.0

    def _step(self) -> None:
        """A millisecond of physics under the last commands; then what the pins show of it."""
        port, plant, n = self.port, self.plant, self.machine.n_axes
        is_released = port.released == (1 << n) - 1
        motor = np.array(port.command_ua[:n]) * self._per_ua * bool(port.enabled)
        counts = self._way.pop() if self._way else None
        if counts is None:
            self._move(motor)
            counts = self.machine.drive.counts(plant.read())
        plant.state.motor = motor
        self.engaged += self._was_released and not is_released
        self._was_released = is_released
        self.steps += 1
        current_ua = plant.effort() / self._per_ua + self._noise_ua * self._rng.standard_normal(n)
        port.sense_ua[:n] = np.rint(current_ua).astype(int).tolist()
        most = self.step_clocks // EDGE_CLOCKS
        near = np.array(port.position[:n])
        port.target[:n] = np.clip(counts, near - most, near + most).tolist()

    def _move(self, motor: np.ndarray) -> None:
        """A step of physics under efforts of the motors (n,). While a brake is engaged nothing moves."""
        if self.port.released == (1 << self.machine.n_axes) - 1:
            self.plant.exert(motor)
        else:
            self.plant.engine.data.qvel[:] = 0.0
