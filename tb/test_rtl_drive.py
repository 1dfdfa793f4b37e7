"""gc_drive equals its twin on every clock, keeps both limits, and is at zero one clock after run."""

import cocotb
import numpy as np

from codes import corners_and_random, fixed_network, pack, unpack
from gravcomp.core.formats import CURRENT_BITS
from gravcomp.twin.drive import LATENCY, drive
from playback import play
from runner import simulate

OUTPUTS = ("out_valid", "out_current", "out_limited", "out_settled")
LARGEST = 2 ** (CURRENT_BITS - 1) - 1


def inputs_of(current: np.ndarray, limit: int, slew: int, spacing: int = LATENCY) -> dict[str, np.ndarray]:
    """A result every spacing clocks; run high from clock 2, limits already there. current (results, axes)."""
    n_clocks = spacing * len(current) + LATENCY + 4
    valid = np.zeros(n_clocks, np.int64)
    valid[4 : 4 + spacing * len(current) : spacing] = 1
    asked = np.concatenate((current[:1].repeat(4, axis=0), current.repeat(spacing, axis=0)))
    asked = np.concatenate((asked, asked[-1:].repeat(n_clocks - len(asked), axis=0)))
    run = (np.arange(n_clocks) >= 2).astype(np.int64)
    rst = np.zeros_like(run)
    cfg = {"cfg_limit": np.full(n_clocks, limit), "cfg_slew": np.full(n_clocks, slew)}
    return {"rst": rst, "run": run, "in_valid": valid, "in_current": asked, **cfg}


async def run_and_compare(dut, inputs) -> dict[str, np.ndarray]:
    """Outputs of the RTL, axes apart, after they were found equal to the twin's."""
    n_axes = inputs["in_current"].shape[1]
    packed = np.array([pack(row, CURRENT_BITS) for row in inputs["in_current"]], object)
    got = await play(dut, {**inputs, "in_current": packed}, OUTPUTS)
    got["out_current"] = unpack(got["out_current"], CURRENT_BITS, n_axes)
    for flags in ("out_limited", "out_settled"):
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
    assert got["out_settled"][-1].all()
    first = np.flatnonzero(got["out_valid"])[0]
    assert first == 4 + LATENCY
    assert not got["out_settled"][first].any()


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
    assert not got["out_settled"][stop + 1 :].any()
    assert not got["out_limited"][stop + 1 :].any()


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
    cfg = {name: rng.integers(0, bits).clip(max=LARGEST).repeat(100) for name in ("cfg_limit", "cfg_slew")}
    current = corners_and_random(CURRENT_BITS, (n_clocks, n_axes), rng) >> rng.integers(0, 30, (n_clocks, 1))
    inputs = {
        "rst": (rng.random(n_clocks) < 0.005).astype(np.int64),
        "run": (rng.random(n_clocks) > 0.02).astype(np.int64),
        "in_valid": (rng.random(n_clocks) < 0.4).astype(np.int64),
        "in_current": current,
        **cfg,
    }
    got = await run_and_compare(dut, inputs)
    fresh = got["out_valid"] == 1
    assert 0.01 < got["out_limited"][fresh].mean() < 0.99
    assert 0.01 < got["out_settled"][fresh].mean() < 0.99


def test_drive_equals_twin():
    simulate("gc_drive", "test_rtl_drive")
