"""gc_edge_watch equals its bit-true model; what it must tell is tested with gc_quad_decoder."""

import os

import cocotb
import numpy as np
import pytest

from gravcomp.twin.encoder import edge_watch
from playback import assert_equal, play
from runner import simulate

GENERICS = {"reversal_clocks_g": 30, "suspect_edges_g": 5, "dither_clocks_g": 10, "dither_edges_g": 8}


@cocotb.test()
async def equals_bit_true(dut):
    """Spells of motion and of dither at random speeds, illegal steps and resets between them."""
    rng = np.random.default_rng(6)
    cocotb.log.info("seed 6")
    steps, n_clocks = [], 20_000
    while sum(clocks for clocks, _ in steps) < n_clocks:
        fastest, up = int(rng.integers(1, 40)), int(rng.integers(2))
        turns = rng.random() < 0.5
        for k in range(int(rng.integers(2, 30))):
            steps.append((int(rng.integers(1, fastest + 1)), up ^ (k & 1 & turns)))
    clocks = np.cumsum([clocks for clocks, _ in steps])
    inside = clocks < n_clocks
    inputs = {name: np.zeros(n_clocks, np.int64) for name in ("rst", "step_valid", "step_up", "step_illegal")}
    inputs["step_valid"][clocks[inside]] = 1
    inputs["step_up"][clocks[inside]] = np.array([up for _, up in steps])[inside]
    inputs["step_illegal"][:] = (rng.random(n_clocks) < 0.002) & (inputs["step_valid"] == 0)
    inputs["rst"][:] = rng.random(n_clocks) < 0.001
    generics = {name.removesuffix("_g"): int(os.environ[name.upper()]) for name in GENERICS}
    expected = edge_watch(*inputs.values(), **generics)
    assert expected.sum() > 10
    assert_equal(await play(dut, inputs, ("out_broken",), reset=False), {"out_broken": expected})


def test_edge_watch_equals_bit_true():
    simulate("gc_edge_watch", "test_rtl_edge_watch", generics=GENERICS)


def test_edge_watch_refuses_a_reserve_of_one_edge():
    with pytest.raises(AssertionError, match="gc_edge_watch: need dither_edges_g >= 2, got 1"):
        simulate("gc_edge_watch", "test_rtl_edge_watch", generics=GENERICS | {"dither_edges_g": 1})
