"""gc_fault_latch equals its twin: all causes until each is cleared, the first ones and where they came."""

import cocotb
import numpy as np

from codes import corners_and_random, fixed_network, pack_rows, unpack
from gravcomp.core.formats import COUNT_BITS
from gravcomp.twin.safety import Cause, FaultLatch
from playback import play
from runner import simulate


@cocotb.test()
async def random_causes_and_clears(dut):
    rng, n_clocks, n_axes = np.random.default_rng(52), 3000, fixed_network().n_axes
    weights = 1 << np.arange(len(Cause))
    fault = (rng.random((n_clocks, len(Cause))) < 0.02) @ weights
    clear = (rng.random((n_clocks, len(Cause))) < rng.choice([0, 0.5, 1], (n_clocks, 1), p=[0.8, 0.15, 0.05])) @ weights
    # No reset for so long that the number of events overflows.
    rst = (rng.random(n_clocks) < 0.005 * (np.arange(n_clocks) > 2000)).astype(np.int64)
    count = corners_and_random(COUNT_BITS, (n_clocks, n_axes), rng)
    packed = pack_rows(count, COUNT_BITS)
    inputs = {"rst": rst, "in_clear": clear, "in_fault": fault, "in_count": packed}
    got = await play(dut, inputs, ["sts_fault", "first_cause", "first_count", "events"])
    got_count = unpack(got["first_count"], COUNT_BITS, n_axes)
    mask, latch = (1 << len(Cause)) - 1, FaultLatch()
    assert (clear & fault).any()
    assert (np.diff(got["events"] % 256) == -255).any(), "no overflow"
    for k in range(n_clocks):
        assert got["sts_fault"][k] & mask == latch.causes, k
        assert got["first_cause"][k] & mask == latch.first_cause, k
        assert got["events"][k] % 256 == latch.events, k
        np.testing.assert_array_equal(got_count[k], latch.first_count)
        latch.clock(bool(rst[k]), int(clear[k]), int(fault[k]), count[k])


def test_fault_latch_equals_twin():
    simulate("gc_fault_latch", "test_rtl_fault_latch")
