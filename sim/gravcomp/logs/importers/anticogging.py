"""Holding current of a brushless motor over one turn forward and one turn back (H. Andrade, LAAS-CNRS 2023, BSD-3).

The rotor is held at steps of 0.002 rad. The direction of approach, which the file does not tell (its velocity is that
of the hold, zero), is that of the turn: forward up to the largest position, backward from there; its speed is the mean
advance over 2 s on either side. No filter. The ideal model says that no current is needed: fm1_a = 0.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from gravcomp.errors import InputError

_NEEDED = ("Time", "Position", "Iq")
_HALF_WINDOW_S = 2.0


def anticogging_csv(path: Path | str) -> str:
    """The CSV of stopped_data.txt. Raises InputError."""
    try:
        table = pd.read_csv(path, skipinitialspace=True)
        t, q, current = (table[name].to_numpy(dtype=float) for name in _NEEDED)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path}: not the anticogging data ({error}); give stopped_data.txt") from error
    if len(t) < 3 or not np.isfinite([t, q, current]).all() or (np.diff(t) < 0).any():
        raise InputError(f"{path}: columns {', '.join(_NEEDED)}: not finite, or time runs back; give stopped_data.txt")
    speed = np.abs(np.interp(t + _HALF_WINDOW_S, t, q) - np.interp(t - _HALF_WINDOW_S, t, q)) / (2.0 * _HALF_WINDOW_S)
    top = int(q.argmax())
    v = np.where(np.arange(len(t)) <= top, 1.0, -1.0) * np.maximum(speed, 1e-4)
    rows = np.column_stack([t, q, v, current])
    head = (
        "# static holds, one turn forward, one turn back; v1 is the signed approach velocity\n"
        "t_s,q1_rad,v1_radps,i1_a,fm1_a\n"
    )
    return head + "".join(f"{t:.3f},{q:.5f},{v:.6f},{i:.5f},0\n" for t, q, v, i in rows)
