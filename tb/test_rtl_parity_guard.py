"""gc_parity_guard equals its twin, finds any single wrong bit in its clock, and is silent without one."""

import cocotb
import numpy as np

from gravcomp.twin.guards import ParityGuard
from playback import assert_equal, play
from runner import simulate

WIDTH = 32
OUTPUTS = ("out_parity", "out_upset")


def stored(load: np.ndarray, following: np.ndarray) -> np.ndarray:
    """What registers hold that are written as the guard is told."""
    word = np.zeros(len(load), np.int64)
    for k in range(len(load) - 1):
        word[k + 1] = following[k] if load[k] else word[k]
    return word


def twin(inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    guard, out = ParityGuard(), {name: [] for name in OUTPUTS}
    for rst, load, following, word in zip(
        *(inputs[name].tolist() for name in ("rst", "in_load", "in_next", "in_word")), strict=True
    ):
        out["out_parity"].append(guard.parity(bool(load), following))
        out["out_upset"].append(guard.upset)
        guard.clock(bool(rst), bool(load), following, word)
    return {name: np.array(values) for name, values in out.items()}


def random_inputs(n_clocks: int, seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    cocotb.log.info("seed %d", seed)
    inputs = {
        "rst": (rng.random(n_clocks) < 0.01).astype(np.int64),
        "in_load": (rng.random(n_clocks) < 0.4).astype(np.int64),
        "in_next": rng.integers(0, 2**WIDTH, n_clocks),
    }
    inputs["rst"][0] = inputs["in_load"][0] = 1
    return {**inputs, "in_word": stored(inputs["in_load"], inputs["in_next"])}


@cocotb.test()
async def every_single_bit_is_found(dut):
    """Each bit in turn is wrong for one clock, and the guard says so in the next, and in no other."""
    inputs = random_inputs(8 * WIDTH, 81)
    inputs["rst"][1:] = 0
    wrong = np.arange(WIDTH) * 8 + 3
    inputs["in_word"][wrong] ^= 1 << np.arange(WIDTH)
    got = await play(dut, inputs, OUTPUTS)
    np.testing.assert_array_equal(np.flatnonzero(got["out_upset"]), wrong + 1)
    assert_equal(got, twin(inputs))


@cocotb.test()
async def random_loads_and_wrong_bits(dut):
    inputs = random_inputs(3000, 82)
    rng = np.random.default_rng(83)
    flips = np.where(rng.random(3000) < 0.2, rng.integers(0, 2**WIDTH, 3000), 0)
    inputs["in_word"] ^= flips
    got = await play(dut, inputs, OUTPUTS)
    assert_equal(got, twin(inputs))
    assert 0.05 < got["out_upset"].mean() < 0.2


def test_parity_guard_equals_twin():
    simulate("gc_parity_guard", "test_rtl_parity_guard", generics={"width_g": WIDTH})
