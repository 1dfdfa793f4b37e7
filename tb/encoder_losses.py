"""How an encoder loses counts, and what looks like it but is none: stimuli for gc_quad_decoder, as encoder_scenarios.

All need a filter of 4 samples or more.
"""

import numpy as np

from encoder_scenarios import delayed, path, stimulus
from gravcomp.twin.encoder import DecoderConfig

SUSPECT_COUNTS = 36  # of gc_edge_watch: 2 suspect_edges_g + 4


def rate_counts(clocks_per_count: int, dither_clocks: int, dither_edges: int = 64) -> int:
    """Of gc_edge_watch: the counts in which a wire that is broken at rest is found."""
    return 2 * dither_edges * dither_clocks // (dither_clocks - 2 * clocks_per_count) + 4


def all_levels(inputs, config: DecoderConfig) -> np.ndarray:
    """Counts of every level of a and b, short ones included, from the start on. a and b must not change at once."""
    phase = 2 * inputs["b"] + (inputs["a"] ^ inputs["b"])
    step = (np.diff(phase, prepend=phase[0]) + 1) % 4 - 1
    assert (step < 2).all()
    return delayed(np.cumsum(step), config)


def is_lost(out) -> bool:
    assert not out["sts_illegal"][0]
    assert not out["sts_referenced"][out["sts_illegal"] == 1].any()
    return bool(out["sts_illegal"][-1])


def dropped_level(config, rng):
    """A level one clock too short, and the other channel changes inside it: four counts."""
    n = config.filter_samples
    inside = int(rng.integers(1, n - 1))
    clocks = [3 * n] * 8 + [inside, n - 1 - inside] + [3 * n] * 8
    inputs = stimulus(path(np.ones(18, np.int64), np.array(clocks), int(rng.integers(4))), config)

    def check(out):
        assert out["count"][-1] == 18 - 4
        assert is_lost(out)

    return inputs, check


def dropped_pulse(config, rng):
    """The same level, and the other channel there and back inside it: no count."""
    n = config.filter_samples
    inputs = stimulus(path(np.ones(8, np.int64), np.full(8, 3 * n), int(rng.integers(4))), config)
    begin = len(inputs["a"]) - 2 * config.latency
    inputs["a"][begin : begin + 3] ^= 1
    inputs["b"][begin + 1 : begin + 2] ^= 1

    def check(out):
        assert out["count"][-1] == 8
        assert out["sts_glitch"][-1]
        assert not is_lost(out)

    return inputs, check


def acceleration(config, rng):
    """Through the limit speed to levels a clock too short: count stops, and says so."""
    level = config.filter_samples - 1
    speeds = [12, 10, 8, 6, 5, 4, 3]
    clocks = [*np.repeat(speeds, 10), *np.tile([level // 2, level - level // 2], 60)]
    inputs = stimulus(path(np.ones(len(clocks), np.int64), np.array(clocks), int(rng.integers(4))), config)

    too_fast = len(inputs["a"]) - 2 * config.latency - 2 - 60 * level

    def check(out):
        assert too_fast < np.flatnonzero(out["sts_illegal"])[0] <= too_fast + config.latency + 4 * level
        assert out["count"][-1] < inputs["position"][-1] - inputs["position"][0] - 80
        assert is_lost(out)

    return inputs, check


def unseen_cycle(config, rng):
    """A whole cycle of short levels at rest: the filters show nothing at all, and four counts are lost."""
    inputs = stimulus(path(np.ones(4, np.int64), np.array([1, 1, 1, 40]), int(rng.integers(4))), config)

    def check(out):
        assert not out["count"].any()
        assert is_lost(out)

    return inputs, check


def pulse_on_both(config, rng):
    """A short pulse that comes and goes on both channels at once is interference, not motion."""
    inputs = stimulus(path(np.ones(8, np.int64), np.full(8, 20), int(rng.integers(4))), config)
    for begin in range(2 * config.latency + 15, len(inputs["a"]) - 2 * config.latency, 20):
        for pin in "ab":
            inputs[pin][begin : begin + 3] ^= 1

    def check(out):
        assert out["count"][-1] == 8
        assert out["sts_glitch"][-1]
        assert not is_lost(out)

    return inputs, check


def both_then_one(config, rng):
    """Both change at once and one of them back: two counts, up or down."""
    inputs = stimulus(np.zeros(80, np.int64), config)
    n = config.filter_samples
    for pin in "ab":
        inputs[pin][40 : 40 + n] = 1
    inputs["a"][38 + n] = 0

    def check(out):
        assert is_lost(out)

    return inputs, check


def short_levels(config, rng):
    """Random levels, many too short: lost if and only if the counts of all levels differ from count in the end."""
    n = config.filter_samples
    inputs = stimulus(np.zeros(int(rng.integers(30, 60)), np.int64), config)
    k = 2 * config.latency + 2
    while k < len(inputs["a"]) - 2 * config.latency - 2:
        inputs["ab"[int(rng.integers(2))]][k:] ^= 1
        k += int(rng.integers(1, n + 3))

    def check(out):
        true = all_levels(inputs, config)
        assert (true - out["count"])[-1] % 4 == 0
        assert is_lost(out) or true[-1] == out["count"][-1]

    return inputs, check


def broken(config, rng, *, at_rest: bool, clocks: int, most_counts: int):
    """A wire of a or b breaks and stays high or low; found within so many counts of travel."""
    start = int(rng.integers(4))
    before = path(np.ones(20, np.int64), np.full(20, clocks), start)
    steps = np.full(most_counts + 40, rng.choice([-1, 1]) if at_rest else 1)
    after = path(steps, np.full(len(steps), clocks), int(before[-1]))
    rest = np.full(3000 if at_rest else 0, before[-1])
    inputs = stimulus(np.concatenate((before, rest, after)), config)
    breaks = 2 * config.latency + 2 + len(before) + (len(rest) // 2 if at_rest else int(rng.integers(4 * clocks)))
    inputs["ab"[int(rng.integers(2))]][breaks:] = int(rng.integers(2))

    def check(out):
        assert out["sts_illegal"].any(), "not found"
        found = int(np.flatnonzero(out["sts_illegal"])[0])
        travel = abs(int(inputs["position"][found - config.latency] - inputs["position"][breaks]))
        assert found > breaks
        assert travel <= most_counts, f"found after {travel} counts"

    return inputs, check


def broken_in_motion(config, rng):
    return broken(config, rng, at_rest=False, clocks=config.reversal_clocks // 3 - 1, most_counts=SUSPECT_COUNTS)


def broken_in_fast_motion(config, rng):
    return broken(config, rng, at_rest=False, clocks=10, most_counts=SUSPECT_COUNTS)


def broken_at_rest(config, rng):
    most = rate_counts(10, config.dither_clocks)
    return broken(config, rng, at_rest=True, clocks=10, most_counts=most)


def indexed(config, clocks: int, period: int, travel: int = 70, times: int = 2):
    """An axis homed slowly at its first mark, which then goes travel counts up and back some times, clocks per count.

    Marks are one count wide, every period counts, 0: just one. Returns the inputs, and the clock in which it is homed.
    """
    first = 8 + config.index_phase
    slow = config.filter_samples + 4
    steps = np.concatenate((np.ones(6, np.int64), np.tile(np.repeat([1, -1], travel), times)))
    each = np.concatenate((np.full(6, slow), np.full(2 * times * travel, clocks)))
    inputs = stimulus(path(steps, each, first - 6), config)
    behind = inputs["position"] - first
    inputs["z"] = (behind % period == 0 if period else behind == 0).astype(np.int64)
    inputs["cfg_home_enable"][1:] = 1
    inputs["cfg_index_position"][:] = first
    inputs["cfg_index_period"][:] = period
    return inputs, int(np.flatnonzero(behind == 0)[0]) + config.latency


def sound(inputs):
    def check(out):
        assert out["sts_referenced"][-1]
        assert not is_lost(out)
        assert out["count"][-1] == inputs["position"][-1]

    return check


def one_mark(config, rng):
    """The only mark passed in both directions, with all counts there: no fault."""
    inputs, _ = indexed(config, int(rng.integers(10, 60)), 0)
    return inputs, sound(inputs)


def periodic_marks(config, rng):
    """Marks of one count passed at all speeds, seen by the filter or too short for it: no fault."""
    fastest = (config.shortest_level + 1) // 2
    inputs, _ = indexed(config, int(rng.integers(fastest, config.mark_clocks + 5)), 4 * int(rng.integers(2, 8)))
    return inputs, sound(inputs)


def wide_mark(config, rng):
    """A mark as wide as an encoder cycle: no fault."""
    inputs, _ = indexed(config, 20, 40)
    behind = (inputs["position"] - 8 - config.index_phase + 20) % 40 - 20
    inputs["z"] = ((behind > -3) & (behind < 3)).astype(np.int64)
    return inputs, sound(inputs)


def wrong_period(config, rng):
    """A mark a cycle from where it should be, as after four lost counts: found at that mark."""
    inputs, _ = indexed(config, 12, 20)
    inputs["cfg_index_period"][:] = int(rng.choice([16, 24]))

    def check(out):
        assert is_lost(out)
        found = np.flatnonzero(out["sts_illegal"])[0]
        assert inputs["position"][found - config.latency] == 8 + config.index_phase + 20

    return inputs, check


def missing_mark(config, rng):
    """z breaks and reads '0': found when the next mark is left."""
    inputs, homed = indexed(config, config.mark_clocks + 8, 20)
    inputs["z"][homed + 100 :] = 0

    def check(out):
        assert is_lost(out)
        found = np.flatnonzero(out["sts_illegal"])[0]
        assert inputs["position"][found - config.latency - 4] == 8 + config.index_phase + 21

    return inputs, check


def stuck_mark(config, rng):
    """z stays high: found where it is more than a cycle away from a mark."""
    inputs, homed = indexed(config, 20, 20)
    inputs["z"][homed:] = 1

    def check(out):
        assert is_lost(out)
        found = np.flatnonzero(out["sts_illegal"])[0]
        assert inputs["position"][found - config.latency] == 8 + config.index_phase + 4

    return inputs, check


def broken_slowly(config, rng, period: int, most_counts: int):
    """A wire of a or b breaks on an axis too slow for its edges to tell: found at a mark."""
    inputs, homed = indexed(config, config.reversal_clocks + 10, period, travel=30, times=1)
    breaks = homed + int(rng.integers(7, 13)) * (config.reversal_clocks + 10)
    inputs["ab"[int(rng.integers(2))]][breaks:] = int(rng.integers(2))

    def check(out):
        assert is_lost(out)
        found = np.flatnonzero(out["sts_illegal"])[0]
        assert np.abs(np.diff(inputs["position"][breaks:found])).sum() <= most_counts

    return inputs, check


def broken_slowly_periodic_marks(config, rng):
    return broken_slowly(config, rng, 20, 20)


def broken_slowly_one_mark(config, rng):
    return broken_slowly(config, rng, 0, 60)


def stuck_index_is_no_reference(config, rng):
    """z high from the start on: the axis passes its index phase and is not referenced."""
    inputs, _ = indexed(config, 20, 0)
    inputs["z"][:] = 1

    def check(out):
        assert not out["sts_referenced"].any()

    return inputs, check


def rests_on_its_index(config, rng):
    """An axis that rests on its index is referenced once it has left it by a cycle and come back."""
    at = 8 + config.index_phase
    inputs = stimulus(path(np.repeat([1, -1], 6), np.full(12, 20), at), config, at)
    inputs["cfg_home_enable"][1:] = 1

    def check(out):
        taken = np.flatnonzero(out["sts_referenced"])[0]
        assert taken == np.flatnonzero(inputs["position"] != at)[-1] + 1 + config.latency
        assert not is_lost(out)

    return inputs, check


def receiver_error(config, rng):
    """error sets the flag in the stated clocks, whatever its length, and holds it against cfg_clear."""
    inputs, homed = indexed(config, 20, 0)
    begin, length = homed + int(rng.integers(100, 200)), int(rng.integers(1, 30))
    inputs["error"][begin : begin + length] = 1
    inputs["cfg_clear"][begin + 5 : begin + length + 20] = 1
    seen = begin + config.sync_stages + 1

    def check(out):
        assert not out["sts_illegal"][:seen].any()
        assert out["sts_illegal"][seen : seen + length].all()
        assert out["sts_referenced"][seen - 1]
        assert not out["sts_referenced"][seen:].any()
        assert not out["sts_illegal"][begin + length + 20]

    return inputs, check


def dither(config, rng):
    """An axis that trembles about one edge, as fast as it may for ever, after a move that can stop there: no fault."""
    slow = config.reversal_clocks
    steps = np.concatenate((np.ones(8, np.int64), np.tile([-1, 1], 100)))
    clocks = np.concatenate((np.full(8, slow), np.full(200, config.dither_clocks)))
    inputs = stimulus(path(steps, clocks, int(rng.integers(4))), config)

    def check(out):
        assert not is_lost(out)
        assert out["count"][-1] == 8

    return inputs, check


def dither_at_random(config, rng):
    """Trembling about one edge at random, with bursts that the reserve takes: no fault."""
    clocks = np.concatenate([[*rng.integers(8, 30, 30), 3000] for _ in range(6)])
    steps = np.resize([-1, 1], len(clocks))
    inputs = stimulus(path([1] * 8 + list(steps), [300] * 8 + list(clocks), int(rng.integers(4))), config)
    return inputs, sound_without_reference(inputs)


def turns_on_the_spot(config, rng):
    """Turns that no machine can make, but with edges of both channels between them: no fault."""
    steps = np.concatenate([np.repeat(rng.choice([-1, 1]), rng.integers(2, 6)) for _ in range(60)])
    inputs = stimulus(path(steps, np.full(len(steps), config.shortest_level + 2)), config)
    return inputs, sound_without_reference(inputs)


def sound_without_reference(inputs):
    def check(out):
        assert not is_lost(out)
        assert out["count"][-1] == inputs["position"][-1] - inputs["position"][0]

    return check


LOSSES = {
    scenario.__name__: scenario
    for scenario in (
        dropped_level, dropped_pulse, acceleration, unseen_cycle, pulse_on_both, both_then_one, short_levels,
        broken_in_motion, broken_in_fast_motion, broken_at_rest, broken_slowly_periodic_marks, broken_slowly_one_mark,
        one_mark, periodic_marks, wide_mark, wrong_period, missing_mark, stuck_mark,
        stuck_index_is_no_reference, rests_on_its_index, receiver_error,
        dither, dither_at_random, turns_on_the_spot,
    )
}  # fmt: skip
