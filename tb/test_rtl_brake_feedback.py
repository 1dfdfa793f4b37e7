"""gc_brake_feedback equals its twin at every clock; a brake that does not do as told is found after the limit."""

import os

import cocotb
import numpy as np
import pytest

from gravcomp.twin.brakes import BrakeFeedback
from playback import flush, play
from runner import simulate

N_AXES = 3
ALL = (1 << N_AXES) - 1
LIMIT = 8
OUTPUTS = ("out_feedback", "out_differs")


async def compare(dut, inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Outputs, after they were found equal to the twin's."""
    twin, expected = BrakeFeedback(N_AXES, int(os.environ["SYNC_STAGES_G"])), {name: [] for name in OUTPUTS}
    names = ("rst", "brake_fed", "in_released", "cfg_clocks")
    for row in zip(*(inputs[name].tolist() for name in names), strict=True):
        expected["out_feedback"].append(twin.feedback)
        expected["out_differs"].append(int(twin.differs))
        twin.clock(*row)
    await flush(dut, 4, brake_fed=0, in_released=0)
    got = await play(dut, inputs, (*OUTPUTS, "upset"))
    assert not got["upset"].any(), "no bit is wrong"
    got["out_feedback"] &= ALL
    for name in OUTPUTS:
        np.testing.assert_array_equal(got[name], expected[name], err_msg=name)
    return got


@cocotb.test()
@cocotb.parametrize(axis=range(N_AXES))
async def a_brake_that_stays_is_found(dut, axis):
    """Told to open, to close: the pin of one axis follows after the limit, which is no fault, or one clock later."""
    for late in (LIMIT, LIMIT + 1):
        told = ((np.arange(200) // 50) % 2).astype(np.int64)
        follows = np.concatenate((np.zeros(late, np.int64), told))[:200]
        pins = told * (ALL & ~(1 << axis)) | follows << axis
        inputs = {"rst": np.zeros(200, np.int64), "brake_fed": pins, "in_released": told * ALL}
        inputs["rst"][0] = 1
        got = await compare(dut, inputs | {"cfg_clocks": np.full(200, LIMIT)})
        found = np.flatnonzero(got["out_differs"])
        latency = int(os.environ["SYNC_STAGES_G"]) + 1
        expected = np.array([50, 100, 150]) + LIMIT + latency if late > LIMIT else []
        np.testing.assert_array_equal(found, expected)


@cocotb.test()
async def random_pins(dut):
    n_clocks, rng = 4000, np.random.default_rng(65)
    cocotb.log.info("seed 65")
    told = rng.integers(0, ALL + 1, n_clocks // 20).repeat(20)
    pins = np.roll(told, 3)
    pins ^= np.where(rng.random(n_clocks // 10) < 0.2, rng.integers(0, ALL + 1, n_clocks // 10), 0).repeat(10)
    inputs = {"rst": (rng.random(n_clocks) < 0.005).astype(np.int64), "brake_fed": pins, "in_released": told}
    inputs["rst"][0] = 1
    got = await compare(dut, inputs | {"cfg_clocks": rng.integers(0, 9, n_clocks // 100).repeat(100)})
    assert 0.02 < got["out_differs"].mean() < 0.9


@pytest.mark.parametrize("guard", ["false", "true"])
def test_brake_feedback_equals_twin(guard):
    generics = {"sync_stages_g": 2, "guard_g": guard}
    simulate("gc_brake_feedback", "test_rtl_brake_feedback", generics=generics)
