"""The robot in the physics engine at a core behind a serial line: its pins at one end, a pseudo terminal at the other.

A bit takes the clocks that it takes on a board. The robot's time goes on by itself, as fast as the core is simulated:
whoever is at the terminal sees a board.
"""

import ctypes
import os
import select
import threading
import time
import tty
from pathlib import Path

import numpy as np

from gravcomp.robot.machine import Machine
from gravcomp.twin.modbus import crc16
from gravcomp_lab.cosim.world import World

_CHARACTERS = 4096  # taken at once
_IDLE_BITS = 20  # after power comes on: a start bit in the very clock in which reset ends would be none
_REST_S = 0.1  # by the computer's clock, for the rest of a frame


class SerialWorld(World):
    """A World without a bus of its own. terminal: the device that a host opens.

    Its thread runs from __enter__ to __exit__.
    """

    hand_counts = 20  # a step has many more clocks than that of a slow core

    def __init__(self, library: Path, machine: Machine, baud: int):
        super().__init__(library, machine)
        self._bit_clocks = round(machine.clock_hz / baud)
        self._core.cosim_line(self._bit_clocks)
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        self.terminal, self._goes_on, self._lock = os.ttyname(self._theirs), True, threading.Lock()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> "SerialWorld":
        self._run(_IDLE_BITS * self._bit_clocks)
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._goes_on = False
        self._thread.join()
        os.close(self._theirs)
        os.close(self._ours)
        self.close()

    def wait(self, steps: int) -> None:
        """So many milliseconds of the robot's."""
        end = self.steps + steps
        while self.steps < end:
            if not self._thread.is_alive():
                raise AssertionError("the simulation has ended")
            time.sleep(1e-3)

    def _put(self, counts: np.ndarray) -> None:
        with self._lock:
            super()._put(counts)

    def _from_host(self) -> bytes:
        """What the host has written. Of a frame that the terminal hands over in parts the robot's time waits for the
        rest: a busy computer would leave a gap in it that a line has not.
        """
        sent = b""
        while select.select([self._ours], [], [], _REST_S if sent else 0.0)[0]:
            sent += os.read(self._ours, _CHARACTERS)
            if crc16(sent) == 0:
                break
        return sent

    def _serve(self) -> None:
        came = (ctypes.c_uint8 * _CHARACTERS)()
        while self._goes_on:
            if sent := self._from_host():
                self._core.cosim_send(sent, len(sent))
            with self._lock:
                self._run(self._bit_clocks)
            if n := self._core.cosim_receive(came, _CHARACTERS):
                os.write(self._ours, bytes(came[:n]))
