"""100 000 random poses through gc_core, as the Verilog that GHDL writes, under Verilator: equal to the bit-true model."""

import json
import subprocess
import time

import numpy as np
import pytest

from codes import fixed_network, unpack
from gravcomp.network import bittrue
from gravcomp.network.quantise import FORCE_BITS
from runner import BUILD, ROOT, verilate
from test_rtl_core import draw_counts
from test_rtl_gates import ghdl_verilog

N_POSES, SEED = 100_000, 21


@pytest.mark.slow
@pytest.mark.gatesim
@pytest.mark.parametrize("lanes", [1, 4, 20])
def test_core_equals_model_on_many_poses(lanes):
    rng = np.random.default_rng(SEED)
    counts = draw_counts(N_POSES, rng)
    # Half of the poses wait up to three intervals before they are offered.
    waits = np.where(rng.random(N_POSES) < 0.5, rng.integers(0, 3 * fixed_network().n_hidden // lanes, N_POSES), 0)
    results, accepted, clocks_per_s = stream(lanes, np.c_[counts, waits])
    assert len(results) == len(accepted) == N_POSES
    assert_equal_to_model(results, counts)
    (latency,) = set((results[:, 5].astype(int) - accepted).tolist())
    measured = {"lanes": lanes, "poses": N_POSES, "latency": latency, "simulated_clocks_per_s": round(clocks_per_s)}
    (BUILD / f"verilated-{lanes}.json").write_text(json.dumps(measured))
    print(measured)


def stream(lanes: int, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Results (k, 6) and clocks of acceptance (k,), as tb/gates/core_bench.cpp writes them, and clocks per second."""
    program = verilate(ghdl_verilog(lanes), "gc_core", ROOT / "tb" / "gates" / "core_bench.cpp", f"core-{lanes}")
    files = [program.parent / name for name in ("poses.bin", "results.bin", "accepted.bin")]
    files[0].write_bytes(poses.astype("<i4").tobytes())
    began = time.perf_counter()
    subprocess.run([program, *files], check=True)
    seconds = time.perf_counter() - began
    results = np.fromfile(files[1], dtype="<u4").reshape(-1, 6)
    return results, np.fromfile(files[2], dtype="<u4").astype(int), int(results[-1, 5]) / seconds


def assert_equal_to_model(results: np.ndarray, counts: np.ndarray) -> None:
    fixed = fixed_network()
    expected = bittrue.core(counts, fixed)
    words = results.astype(object)
    packed = words[:, 0] | words[:, 1] << 32 | words[:, 2] << 64
    np.testing.assert_array_equal(unpack(packed, FORCE_BITS, fixed.n_axes), expected.force_mn)
    axes = np.arange(fixed.n_axes)
    np.testing.assert_array_equal(results[:, 3:4] >> axes & 1 != 0, expected.clamped)
    np.testing.assert_array_equal(results[:, 4:5] >> axes & 1 != 0, expected.saturated)
