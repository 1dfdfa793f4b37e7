"""gc_count_check equals its bit-true model; what it must tell is tested with gc_quad_decoder."""

import cocotb
import numpy as np

from gravcomp.twin.encoder import count_check, glitch_filter, phase_of
from playback import assert_equal, play
from runner import simulate


@cocotb.test()
@cocotb.parametrize(samples=[0, 1, 4])
async def equals_bit_true_on_noise(dut, samples):
    rng = np.random.default_rng(5)
    cocotb.log.info("seed 5")
    n_clocks = 6000
    rst = (rng.random(n_clocks) < 0.003).astype(np.int64)
    pins = np.cumsum(rng.random((2, n_clocks)) < 0.25, axis=1) % 2
    a, b = (glitch_filter(rst, np.ones_like(pin), pin, samples) for pin in pins)
    inputs = {
        "rst": rst,
        "in_valid": (rng.random(n_clocks) < 0.99).astype(np.int64),
        "in_sample": 2 * b["out_sample"] + a["out_sample"],
        "in_level": 2 * b["out_level"] + a["out_level"],
    }
    phases = (phase_of(a[name], b[name]) for name in ("out_sample", "out_level"))
    expected = count_check(rst, inputs["in_valid"], *phases)
    assert expected.any() == (samples > 1)
    assert_equal(await play(dut, inputs, ("out_lost",)), {"out_lost": expected})


def test_count_check_equals_bit_true():
    simulate("gc_count_check", "test_rtl_count_check")
