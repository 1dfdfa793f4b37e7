"""A fast model of a core with gc_motion, as the driver sees it: ModelCore with its registers, moves and records."""

import time

import numpy as np

from gravcomp.driver.registers import MOTION_XML, read_registers
from gravcomp.facts import RECORD_WINDOW, State
from gravcomp.robot.machine import Machine
from gravcomp.twin.recorder import words_of
from support.model_board import ModelCore

MOVE_S = 0.05
SENSE_OFFSET_UA = 77
FORCE_MN = 50_000


class ModelMover(ModelCore):
    """Moves take MOVE_S, then the axes are there. A record per record_s, of position and a current of each axis.

    refuses: a limit is zero. loses: records that found no room.
    """

    def __init__(self, record_s: float = 0.004, refuses: bool = False, loses: int = 0, **values: int | list[int]):
        super().__init__(**values)
        self._motion = read_registers(MOTION_XML)
        self._names = {r.address + 4 * k: (n, k) for n, r in self._motion.items() for k in range(r.count)}
        self._held = {address: self._motion[name].reset for address, (name, _) in self._names.items()}
        self.record_s, self.refuses, self.loses = record_s, refuses, loses
        self.moves, self._refused, self._until, self._began, self.targets = 0, False, 0.0, None, []

    @property
    def _is_ready(self) -> bool:
        runs = self.get("status") & 7 == State.RUN
        return runs and time.monotonic() >= self._until

    @property
    def _records(self) -> int:
        return int((time.monotonic() - self._began) / self.record_s) if self._began else 0

    def _register(self, name: str, **fields: int) -> int:
        return sum(int(value) << self._motion[name].fields[f][0] for f, value in fields.items())

    def read(self, offset: int) -> int:
        window = self._motion["record_word"].address
        if window <= offset < window + 4 * RECORD_WINDOW:
            return self._word((offset - window) // 4)
        if offset not in self._names:
            return super().read(offset)
        name, _ = self._names[offset]
        mode = self._held[self._motion["record_control"].address] & 3
        return {
            "motion_status": self._register(
                "motion_status", moves=self.moves % 256, ready=self._is_ready, refused=self._refused
            ),
            "record_status": self._register("record_status", mode=mode, address_bits=10),
            "record_count": self._records,
            "record_lost": self.loses,
        }.get(name, self._held[offset])

    def write(self, offset: int, word: int) -> None:
        if offset not in self._names:
            super().write(offset, word)
            return
        name, _ = self._names[offset]
        self._held[offset] = word
        if name == "record_control":
            self._began = time.monotonic() if word & 3 else None
        if name == "motion_command":
            self._move()

    def _move(self) -> None:
        self.moves += 1
        self._refused = not self._is_ready
        if not self._refused:
            first = self._motion["move_target"].address
            target = [self._held[first + 4 * k] for k in range(3)]
            self.targets.append(target)
            self._until, self._refused = time.monotonic() + MOVE_S, self.refuses
            for axis, count in enumerate(target):
                self.words[self.map["position_now"].address + 4 * axis] = count

    def _word(self, index: int) -> int:
        """Of a record: the tick is its number, currents are known numbers of it and the axis."""
        record, place = divmod(index, words_of(3))
        number = self._held[self._motion["record_taken"].address] + record
        if place < 2:
            return (number, self.get("status") & 7 | 8)[place]
        axis, field = divmod(place - 2, 5)
        command = 1000 * number + axis
        return (self.get("position_now", axis), 2**31 - 1, command + SENSE_OFFSET_UA, command, FORCE_MN)[field]


class WholeModel(ModelMover):
    """Its motors exert what the model of a machine of three axes says, with noise: nothing is missing."""

    NOISE_UA = 2000

    def __init__(self, machine: Machine, **values: int | list[int]):
        super().__init__(**values)
        self._machine, self._rng = machine, np.random.default_rng(61)

    def _word(self, index: int) -> int:
        axis, field = divmod(index % words_of(3) - 2, 5)
        if axis < 0 or field not in (2, 4):
            return super()._word(index)
        signed = [word - (word >> 31 << 32) for word in (self.get("position_now", k) for k in range(3))]
        effort = self._machine.robot.forces(self._machine.drive.positions(np.array(signed)))[axis]
        if field == 4:
            return round(1e3 * effort) % 2**32
        noise_ua = self.NOISE_UA * self._rng.standard_normal()
        return round(1e6 * effort / self._machine.drive.effort_per_ampere[axis] + noise_ua) % 2**32
