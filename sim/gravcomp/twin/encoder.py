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
    reversal_clocks: int = 250
    dither_clocks: int = 40

    @property
    def latency(self) -> int:
        """Clocks from the edge that samples a pin's new level (that edge included) to count."""
        return self.sync_stages + self.filter_samples + 1

    @property
    def shortest_level(self) -> int:
        """Limit speed: the clocks that each level of a and b must last; two counts take as long."""
        return max(self.filter_samples, 2)

    @property
    def shortest_period(self) -> int:
        """Clocks per four counts at the limit speed: what is faster reads the same, or loses counts."""
        return 2 * self.shortest_level

    @property
    def mark_clocks(self) -> int:
        """Clocks at an index after which z, if it is there, has passed its filter."""
        return 4 * self.filter_samples + 4


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


def glitch_filter(rst: np.ndarray, in_valid: np.ndarray, in_level: np.ndarray, samples: int) -> dict[str, np.ndarray]:
    """gc_glitch_filter: its outputs by port name."""
    if samples == 0:
        quiet = np.zeros_like(in_level)
        return {"out_valid": in_valid, "out_level": in_level, "out_sample": in_level, "out_dropped": quiet}
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
    sample = np.concatenate(([0], in_level[:-1]))
    return {"out_valid": out[0], "out_level": out[1], "out_sample": sample, "out_dropped": out[2]}


def phase_of(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """0 1 2 3 for (a, b) = 00 10 11 01."""
    return 2 * b + (a ^ b)


def count_check(rst: np.ndarray, in_valid: np.ndarray, sample: np.ndarray, level: np.ndarray) -> np.ndarray:
    """gc_count_check: out_lost, from phases instead of levels."""
    out = np.zeros(len(rst), np.int64)
    # Each a clock later.
    sampled = np.diff(sample[:-1], prepend=[0, 0]) % 4
    passed = np.diff(level[:-1], prepend=[0, 0]) % 4
    ahead = np.concatenate(([0], (sample - level)[:-1] % 4))
    valid = np.concatenate(([0], in_valid[:-1]))
    signed = (0, 1, 2, -1)
    lead, both = 0, 0
    for k in range(len(rst) - 1):
        both ^= int(sampled[k] == 2)
        lead += signed[sampled[k]] * (sampled[k] != 2) - signed[passed[k]]
        lead = (lead + 4) % 8 - 4
        starts = not valid[k] or passed[k] == 2
        wrong = lead == -4 or (both and (ahead[k] == 0 or passed[k]))
        if starts or wrong:
            lead, both = signed[ahead[k]], 0
        if rst[k]:
            lead, both = 0, 0
        out[k + 1] = bool(wrong) and not starts and not rst[k]
    return out


def edge_watch(
    rst: np.ndarray,
    step_valid: np.ndarray,
    step_up: np.ndarray,
    step_illegal: np.ndarray,
    reversal_clocks: int,
    dither_clocks: int,
    *,
    suspect_edges: int = 16,
    dither_edges: int = 64,
) -> np.ndarray:
    """gc_edge_watch: out_broken. Takes time by the step, not by the clock."""
    out = np.zeros(len(rst), np.int8)
    known, up, quick, suspect, edges, reserve, before = (0,) * 7
    for k in np.flatnonzero(rst | step_valid | step_illegal).tolist():
        if k == len(rst) - 1:
            break
        broken, new = 0, int(step_up[k])
        if step_valid[k]:
            since, before = k - before, k
            if not known or new == up:
                quick = known and since < reversal_clocks
                suspect, edges, reserve = 0, 0, 0
            else:
                suspect |= quick and since < 2 * reversal_clocks
                edges += suspect
                reserve = max(reserve - since, 0) + dither_clocks
                quick, broken = 0, int(edges == suspect_edges or reserve >= dither_edges * dither_clocks)
            known, up = 1, new
        if broken or step_illegal[k] or rst[k]:
            known, quick, suspect, edges, reserve = (0,) * 5
        out[k + 1] = broken and not rst[k]
    return out


class IndexCheck:
    """gc_index_check, a clock at a time: part of the loop from sts_referenced back to itself."""

    def __init__(self, mark_clocks: int):
        self.mark_clocks = mark_clocks
        self.out_lost = 0
        self.last, self.residue, self.rest = 2**32 - 1, 0, 2**32 - 1
        self.pins_1 = self.pins_2 = (0, 0, 0)
        self.at_2 = self.near_2 = 0
        self.stay = self.seen = 0

    def clock(self, rst: int, step: int, home: int, pins: tuple[int, int, int], period: int) -> None:
        """One clock edge; step is +1, -1 or 0, pins is (in_referenced, in_phase, in_z)."""
        referenced, phase, z = self.pins_2
        at_mark = phase and self.at_2
        self.out_lost = int(z and (not self.near_2 or (phase and not self.at_2)))
        if not at_mark and self.stay == self.mark_clocks and not self.seen:
            self.out_lost = 1
        self.stay = min(self.stay + 1, self.mark_clocks) if at_mark else 0
        self.seen = int(at_mark and (self.seen or z))
        if rst or not referenced:
            self.out_lost = self.stay = self.seen = 0
        self.pins_2, self.at_2 = self.pins_1, int(self.residue == 0)
        self.near_2 = int(self.residue <= 4 or self.rest < 4)
        if home or (step > 0 and self.rest == 0):
            self.residue, self.rest = 0, self.last
        elif step < 0 and self.residue == 0:
            self.residue, self.rest = self.last, 0
        else:
            self.residue, self.rest = (self.residue + step) % 2**32, (self.rest - step) % 2**32
        self.pins_1, self.last = pins, (period - 1) % 2**32


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
    """gc_quad_decoder: its outputs by port name, from all its inputs but clk by port name (bits as integers 0, 1).

    error and cfg_index_period may be left out, as they may in VHDL.
    """
    rst = inputs["rst"]
    inputs = {name: np.zeros_like(rst) for name in ("error", "cfg_index_period")} | dict(inputs)
    filtered = {}
    for pin in "abz":
        synced = synchronizer(rst, inputs[pin], config.sync_stages)
        filtered[pin] = glitch_filter(rst, *synced, config.filter_samples)
    out, steps = _decode(inputs, filtered, config)
    return out | speed_meter(rst, steps["valid"], out["direction"], steps["lost"], config.speed_timeout)


@dataclass(frozen=True)
class _Steps:
    """What the filtered levels of a and b say in each clock, and the registers that hold it.

    count_valid; change: phase against that of the clock before. valid, illegal, up: registers of one clock later.
    """

    count_valid: np.ndarray
    change: np.ndarray
    valid: np.ndarray
    illegal: np.ndarray
    up: np.ndarray


def _steps(rst: np.ndarray, is_known: np.ndarray, phase: np.ndarray) -> _Steps:
    n_clocks = len(rst)
    count_valid, up = np.zeros(n_clocks, np.int64), np.zeros(n_clocks, np.int64)
    valid, illegal = np.zeros(n_clocks, np.int64), np.zeros(n_clocks, np.int64)
    change = np.diff(phase, prepend=0) % 4
    for k in range(n_clocks - 1):
        if not count_valid[k]:
            change[k] = 0
        if not rst[k]:
            count_valid[k + 1] = count_valid[k] or is_known[k]
            valid[k + 1], illegal[k + 1] = change[k] & 1, change[k] == 2
            up[k + 1] = change[k] == 1 if change[k] & 1 else up[k]
    return _Steps(count_valid, change, valid, illegal, up)


class _Reference:
    """Homing of gc_quad_decoder, a clock at a time: sts_referenced, and homed, the clock in which count is set."""

    def __init__(self) -> None:
        self.referenced = self.homed = 0
        self._enable_1 = self._homing = self._armed = 0

    def clock(self, rst: int, enable: int, is_lost: bool, z: int | None) -> bool:
        """One clock edge; z in the index phase, None elsewhere. Returns whether count becomes the index position."""
        self.homed = 0
        if is_lost:
            self.referenced = 0
        if not enable:
            self._homing = self._armed = 0
        elif not self._enable_1:
            self._homing, self._armed, self.referenced = 1, 0, 0
        elif self._homing and z == 0:
            self._armed = 1
        elif self._homing and self._armed and z:
            self._homing, self.homed, self.referenced = 0, 1, 1
        self._enable_1 = enable
        if rst:
            self.referenced = self.homed = self._enable_1 = self._homing = 0
        return bool(self.homed)


def _decode(inputs, filtered, config) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Process p_decode and the checks of its count: its outputs, and the steps for the speed meter."""
    a, b, z = (filtered[pin] for pin in "abz")
    rst, n_clocks = inputs["rst"], len(inputs["rst"])
    phase = phase_of(a["out_level"], b["out_level"])
    steps = _steps(rst, a["out_valid"] & b["out_valid"], phase)
    lost = _lost(inputs, steps, phase_of(a["out_sample"], b["out_sample"]), phase, config)
    in_phase, z_level = (phase == config.index_phase).astype(np.int64), z["out_valid"] & z["out_level"]
    takes_index = steps.count_valid & z["out_valid"] & in_phase

    names = ("count", "sts_referenced", "sts_illegal", "sts_glitch", "step_lost")
    out = {name: np.zeros(n_clocks, np.int64) for name in names}
    check, reference = IndexCheck(config.mark_clocks), _Reference()
    count = illegal = glitch = at_1 = z_1 = 0
    for k in range(n_clocks - 1):
        is_lost = bool(lost[k] or check.out_lost or steps.change[k] == 2)
        step = int(steps.valid[k]) * (2 * int(steps.up[k]) - 1)
        period = int(inputs["cfg_index_period"][k]) % 2**32
        check.clock(rst[k], step, reference.homed, (reference.referenced, at_1, z_1), period)
        at_1, z_1 = int(in_phase[k]), int(z_level[k])
        if inputs["cfg_clear"][k]:
            illegal, glitch = 0, 0
        glitch |= a["out_dropped"][k] | b["out_dropped"][k]
        illegal |= is_lost
        if steps.change[k] & 1:
            count = wrap_32(count + (1 if steps.change[k] == 1 else -1))
        index = int(z["out_level"][k]) if takes_index[k] else None
        if reference.clock(rst[k], int(inputs["cfg_home_enable"][k]), is_lost, index):
            count = int(inputs["cfg_index_position"][k])
        if rst[k]:
            count = illegal = glitch = is_lost = 0
        values = (count, reference.referenced, illegal, glitch, is_lost)
        for name, value in zip(names, values, strict=True):
            out[name][k + 1] = value
    of_speed = {"valid": steps.valid, "lost": out.pop("step_lost")}
    return out | {"count_valid": steps.count_valid, "direction": steps.up}, of_speed


def _lost(inputs, steps: _Steps, sample: np.ndarray, phase: np.ndarray, config: DecoderConfig) -> np.ndarray:
    """What tells of lost counts, but for the index, which depends on the reference."""
    rst = inputs["rst"]
    broken = edge_watch(rst, steps.valid, steps.up, steps.illegal, config.reversal_clocks, config.dither_clocks)
    valid, error = synchronizer(rst, inputs["error"], config.sync_stages)
    return count_check(rst, steps.count_valid, sample, phase) | broken | valid & error
