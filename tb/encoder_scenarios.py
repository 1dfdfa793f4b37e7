"""What an encoder does to a decoder: stimuli for gc_quad_decoder and what its outputs must then show.

Each scenario takes (config, rng) and returns (inputs, check): inputs by port name, and check(outputs), which asserts on
the outputs of the RTL or of its bit-true model. The truth is the encoder's position, not the model.
"""

from collections.abc import Mapping

import numpy as np

from gravcomp.facts import SPEED_METER_CLOCKS
from gravcomp.twin.encoder import NO_PERIOD, DecoderConfig, quadrature, wrap_32

Signals = Mapping[str, np.ndarray]
QUIET = ("rst", "error", "cfg_home_enable", "cfg_index_position", "cfg_index_period", "cfg_clear")


def stimulus(position: np.ndarray, config: DecoderConfig, index_at: int | None = None, index_width: int = 1) -> dict:
    """Pins of an encoder at position[k] counts, from power-up or reset on; it rests at both ends so that count settles.

    z is high on index_width counts around index_at, which must be in the index phase.
    """
    rest = 2 * config.latency + 2
    position = np.concatenate((np.repeat(position[:1], rest), position, np.repeat(position[-1:], rest)))
    a, b = quadrature(position)
    z = np.zeros_like(a)
    if index_at is not None:
        assert index_at % 4 == config.index_phase
        z = (np.abs(2 * (position - index_at) + 1 - index_width % 2) <= index_width - 1).astype(np.int64)
    return {"position": position, "a": a, "b": b, "z": z, **{name: np.zeros_like(a) for name in QUIET}}


def path(steps: np.ndarray, clocks: np.ndarray, start: int = 0) -> np.ndarray:
    """Position per clock: start for one clock, then clocks[j] after each steps[j]."""
    return start + np.repeat(np.cumsum([0, *steps]), [1, *clocks])


def pins(inputs: Signals) -> dict:
    """What is driven: everything but the truth."""
    return {name: values for name, values in inputs.items() if name != "position"}


def delayed(position: np.ndarray, config: DecoderConfig) -> np.ndarray:
    """position when count shows it."""
    return np.concatenate((np.repeat(position[:1], config.latency), position[: -config.latency]))


def jitter(config, rng):
    """Edges bounce for less than the filter, directions change at random: every edge is counted once."""
    n = config.filter_samples
    steps = rng.choice([-1, 1], 12).repeat(rng.integers(1, 12, 12))
    inputs = stimulus(path(steps, rng.integers(2 * n + 1, 4 * n + 8, len(steps)), int(rng.integers(4))), config)
    for pin in "ab":
        for k in np.flatnonzero(np.diff(inputs[pin])) + 1:
            inputs[pin][k : k + max(n - 1, 0)] ^= rng.integers(0, 2, max(n - 1, 0))

    def check(out):
        expected = delayed(inputs["position"], config) - inputs["position"][0]
        changes = np.flatnonzero(np.diff(out["count"]))
        assert len(changes) == np.count_nonzero(np.diff(inputs["position"]))
        assert np.array_equal(np.diff(out["count"])[changes], np.diff(expected)[np.flatnonzero(np.diff(expected))])
        assert out["count"][-1] == expected[-1]
        assert np.array_equal(out["direction"][changes + 1], np.diff(out["count"])[changes] > 0)
        assert not out["sts_illegal"].any()

    return inputs, check


def latency(config, rng):
    """Clean edges: count is the position, late by exactly the stated latency; count_valid comes when stated."""
    steps = rng.choice([-1, 1], 30)
    inputs = stimulus(path(steps, rng.integers(config.filter_samples + 1, 30, 30), 3), config)

    def check(out):
        valid = np.flatnonzero(out["count_valid"])[0]
        assert valid == config.latency, f"count_valid after {valid} clocks"
        assert np.array_equal(out["count"], delayed(inputs["position"], config) - inputs["position"][0])
        assert not out["sts_illegal"].any()
        assert not out["sts_glitch"].any()

    return inputs, check


def glitches(config, rng):
    """Pulses shorter than the filter at rest, on one of a and b at a time, and on z: never counted, reported."""
    n = config.filter_samples
    inputs = stimulus(np.repeat(np.arange(4), 30 * n + 30), config)
    toggles = np.flatnonzero(np.diff(inputs["position"]))
    blocked = np.zeros(len(inputs["a"]), bool)
    for k in [0, *toggles]:
        blocked[k : k + 2 * config.latency + 2] = True
    for selected in ("ab", "z"):
        k = 0
        while n > 1 and k < len(blocked) - 4 * n:
            length = int(rng.integers(1, n))
            if not blocked[k : k + length + n].any():
                inputs[selected[int(rng.integers(len(selected)))]][k : k + length] ^= 1
            k += length + int(rng.integers(1, 2 * n))

    def check(out):
        settled = delayed(inputs["position"], config)
        assert np.array_equal(out["count"], settled)
        assert not out["sts_illegal"].any()
        assert out["sts_glitch"][-1] == (n > 1)

    return inputs, check


def pulse_limit(config, rng):
    """A pulse a clock shorter than the filter is dropped and reported; one of its length is counted, there and back."""
    n = config.filter_samples
    shortest = max(n, 1)
    gap = 2 * shortest + 2 * config.latency
    starts = gap * np.arange(1, 4)
    inputs = stimulus(np.zeros(5 * gap, np.int64), config)
    inputs["a"][starts[0] : starts[0] + shortest - 1] = 1
    inputs["b"][starts[1] : starts[1] + shortest - 1] = 1
    inputs["a"][starts[2] : starts[2] + shortest] = 1
    inputs["cfg_clear"][starts[1:] - 2] = 1

    def check(out):
        for k in starts[1:]:
            assert out["sts_glitch"][k - 2] == (n > 1)
            assert not out["sts_glitch"][k]
        inside = slice(starts[2] + config.latency, starts[2] + config.latency + shortest)
        assert not out["count"][: inside.start].any()
        assert (out["count"][inside] == 1).all()
        assert not out["count"][inside.stop :].any()
        assert not out["sts_glitch"][-1]

    return inputs, check


def limit_speed(config, rng):
    """Two counts per shortest level, up and down: exact."""
    level = config.shortest_level
    clocks = np.tile([level // 2, level - level // 2], 20)
    up = path(np.ones(40, np.int64), clocks, int(rng.integers(4)))
    position = np.concatenate((up, np.repeat(up[-1:], level), up[::-1]))
    inputs = stimulus(position, config)

    def check(out):
        assert np.array_equal(out["count"], delayed(inputs["position"], config) - inputs["position"][0])
        assert out["count"].max() == 40
        assert not out["sts_illegal"].any()
        assert not out["sts_glitch"].any()

    return inputs, check


def beyond_limit(config, rng):
    """Levels one clock shorter than the limit: counts are missing and a flag says so."""
    level = config.shortest_level - 1
    start = int(rng.integers(4))
    if level == 1:
        position = start + 2 * np.arange(40)
    else:
        position = path(np.ones(40, np.int64), np.tile([level // 2, level - level // 2], 20), start)
    inputs = stimulus(position, config)

    def check(out):
        assert out["count"][-1] != inputs["position"][-1] - inputs["position"][0]
        assert out["sts_glitch"][-1] or out["sts_illegal"][-1]

    return inputs, check


def illegal(config, rng):
    """a and b change at once: count stays, the flag stands until cleared and survives a clear at the event."""
    spacing = 4 * config.latency + 10
    steps = np.array([2, 1, -2, -1, 2, 2, 1])
    index_at = config.index_phase
    position = np.concatenate((path([1] * 10, np.full(10, spacing), -5), path(steps, np.full(7, spacing), 5)))
    inputs = stimulus(position, config, index_at)
    inputs["cfg_home_enable"][1:] = 1
    jumps = np.flatnonzero(np.abs(np.diff(inputs["position"])) == 2) + 1
    seen = jumps + config.latency
    inputs["cfg_clear"][seen[0] + 5] = 1
    inputs["cfg_clear"][seen[1] - 1] = 1
    inputs["cfg_index_position"][:] = 1000

    def check(out):
        changes = np.diff(out["count"])
        for k in seen:
            assert changes[k - 1] == 0
            assert out["sts_illegal"][k]
        assert out["sts_referenced"][seen[0] - 1]
        assert not out["sts_referenced"][seen[0] :].any()
        assert not out["sts_illegal"][: seen[0]].any()
        assert out["sts_illegal"][seen[0] : seen[0] + 6].all()
        assert not out["sts_illegal"][seen[0] + 6 : seen[1]].any()
        assert out["sts_illegal"][seen[1] :].all()
        legal = np.flatnonzero(np.abs(np.diff(inputs["position"])) == 1) + config.latency
        after = legal[legal > seen[0]]
        assert np.array_equal(changes[after], np.diff(inputs["position"])[after - config.latency])

    return inputs, check


def index_from_both_sides(config, rng, index_width=1):
    """Homing downwards, then upwards, takes the same place; passes that are not armed change nothing."""
    spacing = config.filter_samples + 3
    index_at = 8 + config.index_phase
    sweep = np.repeat(np.arange(21), spacing)
    position = np.concatenate((sweep, sweep[::-1], sweep, sweep[::-1], sweep))
    inputs = stimulus(position, config, index_at, index_width)
    rest = 2 * config.latency + 2
    starts = rest + len(sweep) * np.arange(5)
    inputs["cfg_home_enable"][starts[1] : starts[2]] = 1
    inputs["cfg_home_enable"][starts[2] + 2 * config.latency + 2 : starts[4]] = 1
    reference = int(rng.integers(-(2**31), 2**31))
    inputs["cfg_index_position"][: starts[2]] = reference
    inputs["cfg_index_position"][starts[2] : starts[3]] = -77
    inputs["cfg_index_position"][starts[3] :] = 5555

    def check(out):
        truth = delayed(inputs["position"], config)
        for number, (begin, end, at_index) in enumerate(((starts[1], starts[2], reference), (starts[2], None, -77))):
            taken = begin + np.flatnonzero(np.diff(out["sts_referenced"][begin:end]) > 0)[0] + 1
            assert truth[taken] == index_at, f"homing {number}: index taken at {truth[taken]}"
            stop = end or len(truth)
            expected = [wrap_32(int(at_index + p - index_at)) for p in truth[taken:stop]]
            assert out["count"][taken:stop].tolist() == expected
        assert not out["sts_referenced"][: starts[1]].any()
        assert out["sts_referenced"][-1]
        assert np.array_equal(out["count"][: starts[1]], truth[: starts[1]] - inputs["position"][0])
        assert not out["sts_illegal"].any()

    return inputs, check


def ungated_index(config, rng):
    """The same with an index pulse as wide as a whole encoder cycle."""
    return index_from_both_sides(config, rng, index_width=4)


def disarmed_index(config, rng):
    """Homing that is switched off before the index is reached does nothing."""
    inputs, _ = index_from_both_sides(config, rng)
    inputs["cfg_home_enable"][:] = 0
    inputs["cfg_home_enable"][10:12] = 1

    def check(out):
        assert not out["sts_referenced"].any()
        assert np.array_equal(out["count"], delayed(inputs["position"] - inputs["position"][0], config))

    return inputs, check


def noisy_index(config, rng):
    """An index pin that never rests as long as the filter asks is no index, even before its first level is known."""
    n = config.filter_samples
    inputs = stimulus(np.full(10 * n + 20, config.index_phase), config)
    inputs["z"][:] = np.arange(len(inputs["z"])) // max(n - 1, 1) % 2
    inputs["cfg_home_enable"][1:] = 1

    def check(out):
        assert out["sts_referenced"].any() == (n < 2)

    return inputs, check


def wrap_around(config, rng):
    """2**31 - 1 is followed by -2**31, and back, without a flag."""
    clocks = config.filter_samples + 2
    up = path(np.ones(12, np.int64), np.full(12, clocks))
    inputs = stimulus(np.concatenate((up, up[::-1])), config, 4 + config.index_phase)
    inputs["cfg_home_enable"][1:] = 1
    inputs["cfg_index_position"][:] = 2**31 - 3

    def check(out):
        turn = int(np.argmax(delayed(inputs["position"], config)))
        assert out["count"][turn] == wrap_32(2**31 - 3 + 12 - 4 - config.index_phase)
        assert out["count"][-1] == 2**31 - 3 - 4 - config.index_phase
        assert {2**31 - 1, -(2**31)} <= set(out["count"].tolist())
        assert not out["sts_illegal"].any()

    return inputs, check


def reset_in_mid_stream(config, rng):
    """After each reset count starts at zero, at the position at which count_valid rises, and follows from there."""
    n = config.filter_samples
    steps = rng.choice([-1, 1], 20).repeat(rng.integers(1, 12, 20))
    inputs = stimulus(path(steps, rng.integers(n + 1, 3 * n + 4, len(steps))), config)
    inputs["cfg_home_enable"][:] = rng.integers(0, 2, len(inputs["a"]))
    resets = np.flatnonzero(rng.random(len(inputs["a"])) < 0.01)
    for k in resets:
        inputs["rst"][k : k + int(rng.integers(1, 4))] = 1
    edges = np.flatnonzero(np.diff(inputs["position"])) + 1
    inputs["rst"][rng.choice(edges, 12) + config.latency - 1] = 1

    def check(out):
        truth = delayed(inputs["position"], config)
        for k in np.flatnonzero(inputs["rst"][:-1]):
            for name in ("count", "count_valid", "speed_valid", "sts_referenced", "sts_illegal", "sts_glitch"):
                assert out[name][k + 1] == 0
        valid = out["count_valid"].astype(bool)
        running = valid[1:] & valid[:-1]
        assert np.array_equal(np.diff(out["count"])[running], np.diff(truth)[running])
        assert not out["sts_illegal"].any()

    return inputs, check


def steady_speed(config, rng):
    """Slow and fast, both directions, also with unequal phases: the period is the sum of four intervals, no ripple."""
    shortest = config.shortest_level
    longest = config.speed_timeout
    cycles = [[shortest] * 4, [shortest, shortest + 3, shortest + 9, shortest + 1], [25] * 4, [longest] * 4]
    spans, steps, clocks = [], [], []
    for sign in (1, -1):
        for cycle in cycles:
            spans.append((len(steps), sign * sum(cycle)))
            steps += [sign] * 12
            clocks += cycle * 3
    inputs = stimulus(path(np.array(steps), np.array(clocks)), config)

    def check(out):
        edges = np.flatnonzero(np.diff(out["count"])) + 1
        assert len(edges) == len(steps)
        for first, period in spans:
            shown = slice(edges[first + 4] + SPEED_METER_CLOCKS, edges[first + 11] + SPEED_METER_CLOCKS)
            assert (out["speed_period"][shown] == period).all()
            assert out["speed_valid"][shown].all()
            assert not out["speed_zero"][shown].any()

    return inputs, check


def fractional_speed(config, rng):
    """Edges between the clock edges: the period is exact to less than one clock."""
    errors = {}
    parts = []
    for spacing in config.shortest_level + rng.uniform(0.0, 40.0, 6):
        parts.append((spacing, np.diff(np.ceil(rng.random() + spacing * np.arange(13))).astype(int)))
    steps = np.concatenate([[sign] * 12 for sign in (1, -1) * 3])
    inputs = stimulus(path(steps, np.concatenate([clocks for _, clocks in parts])), config)

    def check(out):
        edges = np.flatnonzero(np.diff(out["count"])) + 1
        assert len(edges) == len(steps)
        for j, (spacing, _) in enumerate(parts):
            shown = out["speed_period"][edges[12 * j + 4 : 12 * j + 12] + SPEED_METER_CLOCKS]
            assert (np.sign(shown) == (1, -1)[j % 2]).all()
            errors[spacing] = np.abs(np.abs(shown) - 4 * spacing).max()
        assert max(errors.values()) < 1.0, f"largest period error {max(errors.values()):.3f} clocks"

    return inputs, check


def reversal_and_standstill(config, rng):
    """Reversal: unknown until the fifth edge back. Stop: the period grows from the overdue edge on, then zero speed."""
    timeout, spacing = config.speed_timeout, config.shortest_level + 5
    steps = np.repeat([1, -1, -1, -1], [10, 10, 1, 1])
    clocks = np.concatenate((np.full(19, spacing), [2 * timeout, timeout + 1, timeout + 5]))
    inputs = stimulus(path(steps, clocks), config)

    def check(out):
        shown = np.flatnonzero(np.diff(out["count"])) + 1 + SPEED_METER_CLOCKS
        period, valid, zero = out["speed_period"], out["speed_valid"], out["speed_zero"]
        assert not valid[: shown[4]].any()
        assert (period[: shown[4]] == NO_PERIOD).all()
        assert not valid[shown[10] : shown[14]].any()
        assert (period[shown[14] : shown[19]] == -4 * spacing).all()
        overdue = np.arange(timeout)
        slowing = period[shown[19] : shown[19] + timeout]
        assert np.array_equal(slowing, -np.maximum(4 * spacing, 3 * spacing + overdue))
        assert not zero[: shown[19] + timeout].any()
        for edge, next_edge in ((shown[19], shown[20]), (shown[20], shown[21])):
            assert zero[edge + timeout : next_edge].all()
            assert valid[edge + timeout : next_edge].all()
            assert (period[edge + timeout : next_edge] == NO_PERIOD).all()
            assert not zero[next_edge : next_edge + timeout].any()
            assert not valid[next_edge : next_edge + timeout].any()

    return inputs, check


def noise(config, rng):
    """Anything on any input: nothing to claim beyond equality with the bit-true model."""
    inputs = stimulus(np.zeros(2500, np.int64), config)
    length = len(inputs["a"])
    for name, probability in dict(a=0.2, b=0.2, z=0.1, error=0.002, cfg_home_enable=0.05, cfg_clear=0.02).items():
        inputs[name][:] = np.cumsum(rng.random(length) < probability) % 2
    inputs["rst"][1:] = rng.random(length - 1) < 0.003
    inputs["cfg_index_position"][:] = rng.integers(-(2**31), 2**31, length)
    inputs["cfg_index_period"][:] = rng.integers(0, 3, length) * 4
    return inputs, lambda out: None


SCENARIOS = {
    scenario.__name__: scenario
    for scenario in (
        latency, jitter, glitches, pulse_limit, limit_speed, beyond_limit, illegal,
        index_from_both_sides, ungated_index, disarmed_index, noisy_index, wrap_around, reset_in_mid_stream,
        steady_speed, fractional_speed, reversal_and_standstill, noise,
    )
}  # fmt: skip
