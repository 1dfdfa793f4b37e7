"""gc_drive equals its twin on every clock, keeps both limits, and is at zero one clock after run."""

import cocotb
import numpy as np

from codes import corners_and_random, fixed_network, pack_rows, unpack
from gravcomp.core.formats import CURRENT_BITS
from gravcomp.twin.drive import LATENCY, drive
from playback import play
from runner import simulate

OUTPUTS = ("out_valid", "out_current", "out_limited", "out_reached", "out_deviates")
FLAGS = ("out_limited", "out_reached", "out_deviates")
LIMITS = ("cfg_limit", "cfg_slew", "cfg_bound")
LARGEST = 2 ** (CURRENT_BITS - 1) - 1


def inputs_of(
    current: np.ndarray, limit: int | list, slew: int | list, spacing: int = LATENCY, bound: int | list = 0
) -> dict[str, np.ndarray]:
    """A result every spacing clocks; run high from clock 2, limits already there. current (results, axes);
    limit, slew and bound of all axes, or (axes,).
    """
    n_clocks = spacing * len(current) + LATENCY + 4
    valid = np.zeros(n_clocks, np.int64)
    valid[4 : 4 + spacing * len(current) : spacing] = 1
    asked = np.concatenate((current[:1].repeat(4, axis=0), current.repeat(spacing, axis=0)))
    asked = np.concatenate((asked, asked[-1:].repeat(n_clocks - len(asked), axis=0)))
    run = (np.arange(n_clocks) >= 2).astype(np.int64)
    rst = np.zeros_like(run)
    cfg = {"limit": limit, "slew": slew, "bound": bound}
    inputs = {"rst": rst, "run": run, "in_valid": valid, "in_current": asked, "in_clipped": np.zeros_like(asked)}
    return inputs | {f"cfg_{name}": np.full(asked.shape, value) for name, value in cfg.items()}


async def run_and_compare(dut, inputs) -> dict[str, np.ndarray]:
    """Outputs of the RTL, axes apart, after they were found equal to the twin's."""
    n_axes = inputs["in_current"].shape[1]
    packed = pack_rows(inputs["in_current"], CURRENT_BITS)
    clipped = pack_rows(inputs["in_clipped"], 1)
    limits = {name: pack_rows(inputs[name], CURRENT_BITS - 1) for name in LIMITS}
    got = await play(dut, {**inputs, **limits, "in_current": packed, "in_clipped": clipped}, OUTPUTS)
    got["out_current"] = unpack(got["out_current"], CURRENT_BITS, n_axes)
    for flags in FLAGS:
        got[flags] = got[flags][:, None] >> np.arange(n_axes) & 1
    expected = drive(inputs)
    for name in OUTPUTS:
        np.testing.assert_array_equal(got[name], expected[name], err_msg=name)
    return got


@cocotb.test()
async def ramps_from_zero_and_keeps_the_limits(dut):
    n_axes = fixed_network().n_axes
    current = np.tile(np.linspace(900, -1700, n_axes).astype(int), (12, 1))
    got = await run_and_compare(dut, inputs_of(current, limit=1000, slew=150))
    command = got["out_current"][got["out_valid"] == 1]
    steps = np.arange(1, len(command) + 1)[:, None] * 150
    target = np.clip(current, -1000, 1000)
    np.testing.assert_array_equal(command, np.clip(target, -steps, steps))
    np.testing.assert_array_equal(got["out_limited"][-1], np.abs(current[0]) > 1000)
    np.testing.assert_array_equal(got["out_reached"][-1], np.abs(current[0]) <= 1000)
    first = np.flatnonzero(got["out_valid"])[0]
    assert first == 4 + LATENCY
    assert not got["out_reached"][first].any()


@cocotb.test()
async def each_axis_has_its_own_limits(dut):
    """Where an axis ends, how fast it gets there and what deviates, is said by its own limits."""
    axis = np.arange(fixed_network().n_axes)
    limit, slew, bound = 1000 + 100 * axis, 300 + 10 * axis, 50 * axis
    asked = limit + 60
    got = await run_and_compare(dut, inputs_of(np.tile(asked, (12, 1)), limit, slew, bound=bound))
    command = got["out_current"][got["out_valid"] == 1]
    np.testing.assert_array_equal(command[0], slew)
    np.testing.assert_array_equal(command[-1], limit)
    np.testing.assert_array_equal(got["out_deviates"][-1], bound < 60)


@cocotb.test()
@cocotb.parametrize(slew=[LARGEST, LARGEST - 1, 2**30])
async def extreme_currents_do_not_overflow(dut, slew):
    n_axes = fixed_network().n_axes
    sequence = [-LARGEST - 1, LARGEST, -LARGEST, LARGEST, 0, -LARGEST - 1, -1, LARGEST, -LARGEST - 1, -LARGEST - 1]
    got = await run_and_compare(dut, inputs_of(np.tile(sequence, (n_axes, 1)).T, LARGEST, slew))
    command = got["out_current"][got["out_valid"] == 1]
    assert (np.abs(np.diff(command, axis=0, prepend=0)) <= slew).all()
    assert got["out_limited"].any()


@cocotb.test()
@cocotb.parametrize(asked=[0, 1, 1000, -1000, 1001, -1001, LARGEST, -LARGEST - 1])
async def reached_is_the_whole_current(dut, asked):
    """Neither the limit nor a clipped force passes for it; -2**31 is beyond every limit."""
    n_axes = fixed_network().n_axes
    for limit in (0, 1000, LARGEST):
        inputs = inputs_of(np.full((4, n_axes), asked), limit, LARGEST)
        inputs["in_clipped"][:, -1] = 1
        got = await run_and_compare(dut, inputs)
        assert (got["out_reached"][-1] == [*[abs(asked) <= limit] * (n_axes - 1), 0]).all()
        assert (got["out_current"][-1] == asked).all() == (abs(asked) <= limit)


@cocotb.test()
@cocotb.parametrize(limit=[0, 1000, LARGEST])
async def deviation_is_exact(dut, limit):
    """One unit on both sides of the bound, at the largest distances of two currents, too."""
    n_axes = fixed_network().n_axes
    for asked in (1700, -1700, LARGEST, -LARGEST - 1):
        missed = abs(asked) - min(abs(asked), limit)
        for bound in {max(0, min(missed + step, LARGEST)) for step in (-1, 0, 1)}:
            got = await run_and_compare(dut, inputs_of(np.full((2, n_axes), asked), limit, LARGEST, bound=bound))
            first = np.flatnonzero(got["out_valid"])[0]
            assert not got["out_deviates"][: first + 2].any()
            assert (got["out_deviates"][first + 2 :] == (missed > bound)).all(), (asked, bound)


@cocotb.test()
async def a_slow_command_deviates_until_it_is_near(dut):
    n_axes = fixed_network().n_axes
    got = await run_and_compare(dut, inputs_of(np.full((12, n_axes), -1000), LARGEST, slew=100, bound=450))
    fresh = np.flatnonzero(got["out_valid"])
    assert [bool(got["out_deviates"][k + 2].all()) for k in fresh] == [True] * 5 + [False] * 7
    assert [bool(got["out_reached"][k].all()) for k in fresh] == [False] * 9 + [True] * 3


@cocotb.test()
@cocotb.parametrize(stop_after=range(LATENCY + 2))
async def stop_is_zero_one_clock_later(dut, stop_after):
    """From every stage of the pipeline; nothing of the results under way shows after run has risen again."""
    current = np.full((9, fixed_network().n_axes), 5000)
    inputs = inputs_of(current, limit=4000, slew=3000)
    second = 4 + 2 * LATENCY  # clock in which the second command shows
    stop = 4 + LATENCY + stop_after
    inputs["run"][stop : stop + 2] = 0
    inputs["in_valid"][stop + 1 :] = 0
    got = await run_and_compare(dut, inputs)
    assert (got["out_current"][stop] == 3000 + 1000 * (stop >= second)).all()
    assert not got["out_current"][stop + 1 :].any()
    for flags in FLAGS:
        assert not got[flags][stop + 1 :].any(), flags


@cocotb.test()
async def results_that_come_too_soon_are_dropped(dut):
    current = np.arange(1, 41)[:, None] * np.ones(fixed_network().n_axes, np.int64)
    got = await run_and_compare(dut, inputs_of(current, limit=1000, slew=1000, spacing=1))
    command = got["out_current"][got["out_valid"] == 1]
    np.testing.assert_array_equal(command, current[::LATENCY])


@cocotb.test()
@cocotb.parametrize(seed=[61, 62, 63])
async def random_results_limits_and_stops(dut, seed):
    cocotb.log.info("seed %d", seed)
    rng, n_clocks, n_axes = np.random.default_rng(seed), 3000, fixed_network().n_axes
    bits = 2 ** rng.integers(4, 32, n_clocks // 100)
    cfg = {name: rng.integers(0, bits[:, None], (len(bits), n_axes)).clip(max=LARGEST).repeat(100, axis=0)
           for name in LIMITS}  # fmt: skip
    current = corners_and_random(CURRENT_BITS, (n_clocks, n_axes), rng) >> rng.integers(0, 30, (n_clocks, 1))
    inputs = {
        "rst": (rng.random(n_clocks) < 0.005).astype(np.int64),
        "run": (rng.random(n_clocks) > 0.02).astype(np.int64),
        "in_valid": (rng.random(n_clocks) < 0.4).astype(np.int64),
        "in_current": current,
        "in_clipped": (rng.random((n_clocks, n_axes)) < 0.1).astype(np.int64),
        **cfg,
    }
    inputs["in_valid"][:2] = 0  # the limits of the test before are still there
    got = await run_and_compare(dut, inputs)
    fresh = got["out_valid"] == 1
    assert 0.01 < got["out_limited"][fresh].mean() < 0.99
    assert 0.01 < got["out_reached"][fresh].mean() < 0.99
    assert 0.01 < got["out_deviates"][fresh].mean() < 0.99


def test_drive_equals_twin():
    simulate("gc_drive", "test_rtl_drive")
