"""A fast model of a board behind a pseudo terminal: the twin of gc_modbus on registers that do what the driver needs.

What goes wrong on a line is drawn by seed: answers lost or damaged, requests damaged, silence.
"""

import os
import select
import threading
import time
import tty
from dataclasses import dataclass, field

import numpy as np

from gravcomp.driver.registers import read_registers
from gravcomp.facts import ALWAYS, LOAD_KEY, Cause, State
from gravcomp.twin.modbus import ModbusSlave, SlaveError

# Silence that ends a frame. The other end writes a frame in one piece.
GAP_S = 0.002


class ModelCore:
    """Registers of gc_system: those written hold; control, brakes, results and loading as the drivers see them."""

    def __init__(self, **values: int | list[int]):
        self.map = read_registers()
        self.words, self.loaded, self.kicks, self.faults = {}, [], 0, 0
        self._by_address = {r.address + 4 * k: (name, r) for name, r in self.map.items() for k in range(r.count)}
        for name, register in self.map.items():
            given = values.get(name, register.reset)
            words = given if isinstance(given, list) else [given] * register.count  # fewer than eight axes
            for k in range(register.count):
                self.words[register.address + 4 * k] = words[k] if k < len(words) else 0
        self.image, self.is_loadable, self.is_unlocked, self.bank, self.bad = [], True, False, 0, False
        self.accepts, self.start = True, time.monotonic()

    def get(self, name: str, index: int = 0) -> int:
        return self.words[self.map[name].address + 4 * index]

    def put(self, name: str, word: int) -> None:
        self.words[self.map[name].address] = word

    def _field(self, name: str, **values: int) -> int:
        return sum(value << self.map[name].fields[f][0] for f, value in values.items())

    def read(self, offset: int) -> int:
        name, register = self._by_address.get(offset, ("", None))
        if register is None or not register.readable:
            raise SlaveError
        if name == "result_number":
            return self.results()
        if name == "control_now":
            self._follow()
        if name == "load_status":
            return self._field("load_status", loadable=self.is_loadable, unlocked=self.is_unlocked, bad=self.bad,
                               bank=self.bank)  # fmt: skip
        return self.words[offset]

    def write(self, offset: int, word: int) -> None:
        name, register = self._by_address.get(offset, ("", None))
        if register is None or not register.writable:
            raise SlaveError
        if name in ("load_command", "load_crc", "load_word") and not self.is_unlocked:
            raise SlaveError
        if register.holding:
            self.words[offset] = word
        if name == "load_unlock":
            self.is_unlocked = word == LOAD_KEY
        if name == "load_word":
            self.image.append(word)
        if name == "load_command":
            self._load(word)
        if name == "command":
            self.kicks += word >> 1 & 1

    def results(self) -> int:
        """A result per tick since the model was made, while the tick is on."""
        per_s = self.get("clock_hz") / self.get("tick_clocks")
        return int((time.monotonic() - self.start) * per_s) if self.get("control") >> 1 & 1 else 0

    def fault(self, cause: Cause) -> None:
        """A fault that lasts."""
        for name in ("fault", "cause", "first_cause"):
            self.put(name, cause.mask)
        self.put("status", self._field("status", state=State.FAULT))

    def _follow(self) -> None:
        """The core takes control over; with the brakes asked for and no cause present they are released."""
        control = self.get("control")
        self.put("control_now", control)
        if self.get("cause") & (ALWAYS if not control & 1 else -1):
            return
        state = State.RUN if control & 1 else State.BRAKED
        released = 7 * (control & 1)
        self.put("status", self._field("status", state=state, released=released, run=control & 1))

    def _load(self, word: int) -> None:
        if word & 1:
            self.image, self.bad = [], False
        if word & 2:
            self.bad = not self.accepts
            self.is_unlocked = False
            if self.accepts:
                self.bank = 2 if self.bank == 1 else 1
        if word & 4:
            self.bank = 0


@dataclass
class Noise:
    """Parts of the frames to which this happens, drawn by seed. silent: no answer from here on."""

    lost_answers: float = 0.0
    damaged_answers: float = 0.0
    damaged_requests: float = 0.0
    silent: bool = False
    seed: int = 0
    rng: np.random.Generator = field(init=False)

    def __post_init__(self):
        self.rng = np.random.default_rng(self.seed)

    def strikes(self, part: float) -> bool:
        return bool(self.rng.random() < part)

    def damage(self, frame: bytes) -> bytes:
        damaged = bytearray(frame)
        damaged[self.rng.integers(len(frame))] ^= 1 << self.rng.integers(8)
        return bytes(damaged)


class ModelBoard:
    """A context: the slave on a pseudo terminal; port is the other end's name."""

    def __init__(self, core: ModelCore, noise: Noise | None = None, unit: int = 1):
        self.core, self.noise, self.slave = core, noise or Noise(), ModbusSlave(core, unit)

    def __enter__(self) -> "ModelBoard":
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        self.port, self._stop = os.ttyname(self._theirs), threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._stop.set()
        self._thread.join()
        os.close(self._theirs)
        os.close(self._ours)

    def _serve(self) -> None:
        frame = b""
        while not self._stop.is_set():
            ready, _, _ = select.select([self._ours], [], [], GAP_S if frame else 0.05)
            if ready:
                frame += os.read(self._ours, 4096)
            elif frame:
                self._answer(frame)
                frame = b""

    def _answer(self, frame: bytes) -> None:
        noise = self.noise
        if noise.silent:
            return
        answer = self.slave.answer(noise.damage(frame) if noise.strikes(noise.damaged_requests) else frame)
        if answer is None or noise.strikes(noise.lost_answers):
            return
        os.write(self._ours, noise.damage(answer) if noise.strikes(noise.damaged_answers) else answer)
