"""Clock-accurate twin of gc_timeout, as a register and as arrays over clocks."""

import numpy as np


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
