"""Clock-accurate twin of gc_drive: results of the core to current commands with limited magnitude and slew.

Element k of an array is the value just before rising clock edge k, as in gravcomp.twin.encoder.
"""

from collections.abc import Mapping

import numpy as np

LATENCY = 6  # clocks from in_valid to out_valid, and the fewest between two results that are both taken


def drive(inputs: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """gc_drive: its outputs by port name, from all its inputs but clk by port name.

    in_current and out_current (clocks, axes), uA, int64; out_limited and out_settled (clocks, axes); others (clocks,).
    """
    asked_ua = inputs["in_current"]
    out = {name: np.zeros_like(asked_ua) for name in ("out_current", "out_limited", "out_settled")}
    out["out_valid"] = np.zeros(len(asked_ua), np.int64)
    valid = [False] * (LATENCY - 1)
    command, step, limited, settled, out_limited, out_settled = np.zeros((6, asked_ua.shape[1]), np.int64)
    limit, slew = 0, 0
    for k in range(len(asked_ua) - 1):
        is_taken, is_new = inputs["in_valid"][k] and not any(valid), valid[-1]
        if is_new:
            command, out_limited, out_settled = command + step, limited, settled
        if is_taken:
            target = np.clip(asked_ua[k], -limit, limit)
            step = np.clip(target - command, -slew, slew)
            limited, settled = target != asked_ua[k], step == target - command
        elif not any(valid[:-1]):
            limit, slew = inputs["cfg_limit"][k], inputs["cfg_slew"][k]
        valid = [is_taken, *valid[:-1]]
        if inputs["rst"][k] or not inputs["run"][k]:
            valid, is_new = [False] * len(valid), False
            command, out_limited, out_settled = np.zeros((3, asked_ua.shape[1]), np.int64)
        out["out_valid"][k + 1], out["out_current"][k + 1] = is_new, command
        out["out_limited"][k + 1], out["out_settled"][k + 1] = out_limited, out_settled
    return out
