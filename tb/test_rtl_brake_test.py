"""gc_brake_test equals its twin at every clock; a brake that does not obey, or a path that holds nothing, fails it."""

import cocotb
import numpy as np
import pytest

from gravcomp.twin.brakes import BrakeTest
from playback import play
from runner import simulate

N_AXES = 3
ALL = (1 << N_AXES) - 1
LIMIT = 6
OUTPUTS = ("out_first", "out_second", "out_done", "out_failed")
PHASES = 4 * N_AXES


def driven(n_clocks: int, start: np.ndarray, rst: np.ndarray, limit: np.ndarray, brake) -> tuple[dict, dict]:
    """Inputs and the twin's outputs; brake(first, second, clock) is what the read-back pins say two clocks later."""
    test, feedback = BrakeTest(N_AXES), [0, 0]
    inputs = {"rst": rst, "in_start": start, "cfg_clocks": limit, "in_feedback": np.zeros(n_clocks, np.int64)}
    out = {name: np.zeros(n_clocks, np.int64) for name in OUTPUTS}
    for k in range(n_clocks):
        inputs["in_feedback"][k] = feedback[-1]
        for name in OUTPUTS:
            out[name][k] = getattr(test, name.removeprefix("out_"))
        feedback = [brake(test.first, test.second, k), feedback[0]]
        test.clock(bool(rst[k]), bool(start[k]), int(inputs["in_feedback"][k]), int(limit[k]))
    return inputs, out


async def compare(dut, inputs: dict, expected: dict) -> None:
    got = await play(dut, inputs, (*OUTPUTS, "upset"))
    assert not got["upset"].any(), "no bit is wrong"
    for name in OUTPUTS:
        mask = ALL if name in ("out_first", "out_second") else 1
        np.testing.assert_array_equal(got[name] & mask, expected[name], err_msg=name)


def whole_test(brake, limit: int = LIMIT) -> tuple[dict, dict]:
    n_clocks = 2 * PHASES * (limit + 2)
    start = (np.arange(n_clocks) >= 5).astype(np.int64)
    zero = np.zeros(n_clocks, np.int64)
    return driven(n_clocks, start, zero, zero + limit, brake)


@cocotb.test()
async def brakes_that_obey_pass(dut):
    """Each axis is released by one path, by both, by the other one, by none; a phase lasts the limit and 2 clocks."""
    inputs, expected = whole_test(lambda first, second, _: first & second)
    await compare(dut, inputs, expected)
    steps = np.flatnonzero(np.diff(expected["out_first"] * 16 + expected["out_second"])) + 1
    paths = [(int(expected["out_first"][k]), int(expected["out_second"][k])) for k in steps]
    one = [1 << axis for axis in range(N_AXES)]
    assert paths == [pair for axis in one for pair in ((axis, 0), (axis, axis), (0, axis), (0, 0))]
    np.testing.assert_array_equal(np.diff(steps), LIMIT + 2)
    assert np.flatnonzero(expected["out_done"])[0] == steps[-1] + LIMIT + 2
    assert not expected["out_failed"].any()


@cocotb.test()
@cocotb.parametrize(
    fault=[
        "first_path_holds_nothing",
        "second_path_holds_nothing",
        "never_opens",
        "never_closes",
        "another_opens",
        "late",
    ]
)
async def brakes_that_do_not_obey_fail(dut, fault):
    brakes = {
        "first_path_holds_nothing": lambda first, second, _: second,
        "second_path_holds_nothing": lambda first, second, _: first,
        "never_opens": lambda first, second, _: first & second & 0b101,
        "never_closes": lambda first, second, k: first & second | (k > 40) << 1,
        "another_opens": lambda first, second, _: first & second | (first & second & 1) << 2,
    }
    if fault == "late":
        inputs, expected = whole_test(lambda first, second, _: first & second, limit=0)
    else:
        inputs, expected = whole_test(brakes[fault])
    await compare(dut, inputs, expected)
    assert expected["out_failed"].any()


@cocotb.test()
async def random_starts_resets_and_brakes(dut):
    n_clocks, rng = 6000, np.random.default_rng(63)
    cocotb.log.info("seed 63")
    start = (rng.random(n_clocks // 150) < 0.8).astype(np.int64).repeat(150)
    rst = (rng.random(n_clocks) < 0.003).astype(np.int64)
    limit = rng.integers(0, 7, n_clocks // 200).repeat(200)
    wrong = np.where(rng.random(n_clocks) < 0.02, rng.integers(0, ALL + 1, n_clocks), 0)
    inputs, expected = driven(n_clocks, start, rst, limit, lambda first, second, k: first & second ^ int(wrong[k]))
    await compare(dut, inputs, expected)
    assert expected["out_done"].any()
    assert expected["out_failed"].any()


@pytest.mark.parametrize("guard", ["false", "true"])
def test_brake_test_equals_twin(guard):
    simulate("gc_brake_test", "test_rtl_brake_test", generics={"guard_g": guard})
