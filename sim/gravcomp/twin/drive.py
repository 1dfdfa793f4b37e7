"""Clock-accurate twin of gc_drive: results of the core to current commands with limited magnitude and slew.

Element k of an array is the value just before rising clock edge k, as in gravcomp.twin.encoder.
"""

from collections.abc import Mapping

import numpy as np

from gravcomp.facts import DRIVE_CLOCKS

LATENCY = DRIVE_CLOCKS  # also the fewest clocks between two results that are both taken


def drive(inputs: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """gc_drive: its outputs by port name, from all its inputs but clk by port name.

    in_current, out_current, cfg_limit, cfg_slew and cfg_bound (clocks, axes), uA, int64; in_clipped, out_limited,
    out_reached and out_deviates (clocks, axes); others (clocks,).
    """
    asked_ua = inputs["in_current"]
    names = ("out_current", "out_limited", "out_reached", "out_deviates")
    out = {name: np.zeros_like(asked_ua) for name in names}
    out["out_valid"] = np.zeros(len(asked_ua), np.int64)
    state = _Drive(asked_ua.shape[1])
    for k in range(len(asked_ua) - 1):
        state.clock({name: values[k] for name, values in inputs.items()})
        out["out_valid"][k + 1], out["out_current"][k + 1] = state.is_new, state.command
        out["out_limited"][k + 1], out["out_reached"][k + 1] = state.out_limited, state.out_reached
        out["out_deviates"][k + 1] = state.out_deviates
    return out


class _Drive:
    """A clock at a time: command, whether it is new, and its flags."""

    def __init__(self, n_axes: int) -> None:
        self._limit = self._slew = self._bound = self._asked = self._step = self._limited = self._reached = np.zeros(
            n_axes, np.int64
        )
        self._stop()

    def _stop(self) -> None:
        zero = np.zeros_like(self._asked)
        self._valid, self.is_new, self._was_new = [False] * (LATENCY - 1), False, False
        self.command, self.out_limited, self.out_reached, self.out_deviates, self._miss = zero, zero, zero, zero, zero

    def clock(self, inputs: Mapping[str, np.ndarray]) -> None:
        """One rising edge, at which the inputs have these values."""
        if self._was_new:
            self.out_deviates = np.abs(self._miss) > self._bound
        self._was_new, self._miss = self.is_new, self._asked - self.command
        self.is_new = self._valid[-1]
        is_taken = bool(inputs["in_valid"]) and not any(self._valid)
        if self.is_new:
            self.command = self.command + self._step
            self.out_limited, self.out_reached = self._limited, self._reached
        if is_taken:
            self._take(inputs["in_current"], inputs["in_clipped"])
        elif not any(self._valid[:-1]):
            self._limit, self._slew = inputs["cfg_limit"], inputs["cfg_slew"]
        self._bound = inputs["cfg_bound"]
        self._valid = [is_taken, *self._valid[:-1]]
        if inputs["rst"] or not inputs["run"]:
            self._stop()

    def _take(self, asked: np.ndarray, clipped: np.ndarray) -> None:
        target = np.clip(asked, -self._limit, self._limit)
        self._asked, self._step = asked, np.clip(target - self.command, -self._slew, self._slew)
        self._limited = target != asked
        self._reached = (self.command + self._step == asked) & (clipped == 0)
