"""Bit-true, cycle-accurate model of the encoder interface: one function per RTL entity.

Every signal is an array over clocks; element k is the value just before rising clock edge k: what that edge samples.
A register is thus y[k + 1] = f(x[k]) with y[0] its power-up value, a wire y[k] = x[k].
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

NO_PERIOD = 2**31 - 1  # speed_period at standstill and while unknown
EDGES_PER_PERIOD = 5  # the edge that ends a period of four counts is the fifth


@dataclass(frozen=True)
class DecoderConfig:
    """The generics of gc_quad_decoder, without their suffix."""

    sync_stages: int = 2
    filter_samples: int = 4
    index_phase: int = 2
    speed_timeout: int = 10_000_000

    @property
    def latency(self) -> int:
        """Clocks from the edge that samples a pin's new level (that edge included) to count."""
        return self.sync_stages + self.filter_samples + 1

    @property
    def shortest_level(self) -> int:
        """Limit speed: the clocks that each level of a and b must last; two counts take as long."""
        return max(self.filter_samples, 2)


def quadrature(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Levels (a, b) of an encoder at positions in counts: 00 10 11 01 for position modulo 4 = 0 1 2 3."""
    low, high = position & 1, position >> 1 & 1
    return low ^ high, high


def wrap_32(value: int) -> int:
    """Two's complement of 32 bits."""
    return (value + 2**31) % 2**32 - 2**31


def synchronizer(rst: np.ndarray, async_data: np.ndarray, stages: int) -> tuple[np.ndarray, np.ndarray]:
    """gc_synchronizer, one bit: (out_valid, out_data)."""
    clocks = np.arange(len(rst))
    last_reset = np.maximum.accumulate(np.where(rst, clocks, -1))
    valid = np.concatenate(([0], (clocks - last_reset >= stages)[:-1])).astype(np.int64)
    data = np.concatenate((np.zeros(stages, np.int64), async_data))[: len(rst)]
    return valid, data


def glitch_filter(
    rst: np.ndarray, in_valid: np.ndarray, in_level: np.ndarray, samples: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """gc_glitch_filter: (out_valid, out_level, out_dropped)."""
    if samples == 0:
        return in_valid, in_level, np.zeros_like(in_level)
    out = np.zeros((3, len(rst)), np.int64)
    known, level, run = 0, 0, 0
    for k in range(len(rst) - 1):
        new, dropped = int(in_level[k]), 0
        if not known:
            run = run + 1 if new == level else 1
            level = new
        elif new != level:
            run += 1
        else:
            dropped = int(run > 0)
            run = 0
        if run == samples:
            known, level, run = 1, new, 0
        if rst[k] or not in_valid[k]:
            known, run, dropped = 0, 0, 0
        out[:, k + 1] = known, level, dropped
    return out[0], out[1], out[2]


def speed_meter(
    rst: np.ndarray, step_valid: np.ndarray, step_up: np.ndarray, step_lost: np.ndarray, timeout: int
) -> dict[str, np.ndarray]:
    """gc_speed_meter: its outputs by port name."""
    n_clocks = len(rst)
    edges, up, zero, idle = 0, 0, 0, 0
    stamps = [0] * (EDGES_PER_PERIOD - 1)
    stage_1 = np.zeros((n_clocks, 5), np.int64)  # edges, up, zero, step, elapsed
    for k in range(n_clocks - 1):
        elapsed = k - stamps[-1]
        if step_valid[k]:
            edges = 1 if edges == 0 or step_up[k] != up else min(edges + 1, EDGES_PER_PERIOD)
            stamps = [k, *stamps[:-1]]
            up, zero, idle = step_up[k], 0, 0
        elif step_lost[k]:
            edges, zero, idle = 0, 0, 0
        elif idle == timeout - 1:
            edges, zero = 0, 1
        else:
            idle += 1
        if rst[k]:
            edges, zero, idle = 0, 0, 0
        stage_1[k + 1] = edges, up, zero, step_valid[k], elapsed
    return _signed_period(rst, *stage_1.T)


def _signed_period(rst, edges, up, zero, step, elapsed) -> dict[str, np.ndarray]:
    """Stages 2 and 3 of gc_speed_meter."""
    period = 0
    valid_3, zero_3 = np.zeros_like(edges), np.zeros_like(edges)
    period_3 = np.full_like(edges, NO_PERIOD)
    valid_2, up_2, zero_2 = 0, 0, 0
    for k in range(len(rst) - 1):
        if not rst[k]:
            valid_3[k + 1], zero_3[k + 1] = valid_2 | zero_2, zero_2
            if valid_2:
                period_3[k + 1] = period if up_2 else -period
        if step[k] or elapsed[k] > period:
            period = int(elapsed[k])
        valid_2, up_2, zero_2 = int(edges[k] == EDGES_PER_PERIOD), up[k], zero[k]
        if rst[k]:
            valid_2, zero_2 = 0, 0
    return {"speed_valid": valid_3, "speed_zero": zero_3, "speed_period": period_3}


def quad_decoder(inputs: Mapping[str, np.ndarray], config: DecoderConfig) -> dict[str, np.ndarray]:
    """gc_quad_decoder: its outputs by port name, from all its inputs but clk by port name (bits as integers 0, 1)."""
    rst = inputs["rst"]
    filtered = []
    for pin in "abz":
        synced = synchronizer(rst, inputs[pin], config.sync_stages)
        filtered.append(glitch_filter(rst, *synced, config.filter_samples))
    out, steps = _decode(inputs, np.array(filtered), config)
    return out | speed_meter(rst, steps[0], out["direction"], steps[1], config.speed_timeout)


def _decode(inputs, filtered, config) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Process p_decode: its outputs, and (step_valid, step_lost). filtered[pin a b z][valid level dropped][k]."""
    (valid_a, a, dropped_a), (valid_b, b, dropped_b), (valid_z, z, _) = filtered
    phase = 2 * b + (a ^ b)
    names = ("count_valid", "count", "direction", "sts_referenced", "sts_illegal", "sts_glitch")
    out = {name: np.zeros(len(phase), np.int64) for name in names}
    steps = np.zeros((2, len(phase)), np.int64)
    count_valid, count, direction, referenced, illegal, glitch, phase_1, enable_1, armed = (0,) * 9
    for k in range(len(phase) - 1):
        change = (phase[k] - phase_1) % 4 if count_valid else 0
        if inputs["cfg_clear"][k]:
            illegal, glitch = 0, 0
        glitch |= dropped_a[k] | dropped_b[k]
        if change == 2:
            illegal, referenced = 1, 0
        elif change:
            direction = int(change == 1)
            count = wrap_32(count + 2 * direction - 1)
        enable = inputs["cfg_home_enable"][k]
        if enable and not enable_1:
            armed, referenced = 1, 0
        elif enable and armed and count_valid and valid_z[k] and z[k] and phase[k] == config.index_phase:
            armed, referenced, count = 0, 1, int(inputs["cfg_index_position"][k])
        enable_1 = enable
        if valid_a[k] and valid_b[k]:
            count_valid, phase_1 = 1, phase[k]
        steps[:, k + 1] = change in (1, 3), change == 2
        if inputs["rst"][k]:
            count_valid, count, direction, referenced, illegal, glitch, enable_1, armed = (0,) * 8
            steps[:, k + 1] = 0
        for name, value in zip(names, (count_valid, count, direction, referenced, illegal, glitch), strict=True):
            out[name][k + 1] = value
    return out, steps
