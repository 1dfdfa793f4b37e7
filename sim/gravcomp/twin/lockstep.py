"""Twin of gc_lockstep, which compares two copies of a circuit."""

import numpy as np


def lockstep(rst: np.ndarray, in_main: np.ndarray, in_twin: np.ndarray, lag: int) -> np.ndarray:
    """out_differ (n,) from the inputs (n,), one value per clock; in_twin is lag clocks behind in_main."""
    behind = np.concatenate([np.zeros(lag, np.int64), in_main[:-lag]])
    differ = (in_twin != behind) & (rst == 0)
    return np.concatenate([[0], differ[:-1]]).astype(np.int64)
