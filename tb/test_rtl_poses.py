"""Many random poses through gc_core, as Verilog of GHDL and as ECP5 netlist, under Verilator: equal to the model."""

import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from codes import fixed_network, unpack
from gravcomp.core.formats import FORCE_BITS
from gravcomp.twin import network as bittrue
from gravcomp_lab.benches.core import draw_counts
from runner import ROOT, verilate
from support.netlists import ghdl_verilog, netlist

N_POSES, SEED = {"ghdl": 100_000, "ecp5": 10_000}, 21


@pytest.mark.slow
@pytest.mark.gatesim
@pytest.mark.parametrize(("kind", "lanes"), [("ghdl", 1), ("ghdl", 4), ("ghdl", 20), ("ecp5", 1), ("ecp5", 4)])
def test_core_equals_model_on_many_poses(kind, lanes):
    rng, n_poses = np.random.default_rng(SEED), N_POSES[kind]
    counts = draw_counts(n_poses, rng)
    # Half of the poses wait up to three intervals before they are offered.
    waits = np.where(rng.random(n_poses) < 0.5, rng.integers(0, 3 * fixed_network().n_hidden // lanes, n_poses), 0)
    verilog = [ghdl_verilog(lanes)] if kind == "ghdl" else netlist(lanes, kind)
    results, accepted, clocks_per_s = stream(verilog, f"{kind}-{lanes}", np.c_[counts, waits])
    assert len(results) == len(accepted) == n_poses
    assert_equal_to_model(results, counts)
    (latency,) = set((results[:, 5].astype(int) - accepted).tolist())
    print(f"\n{kind}, {lanes} lanes: {n_poses} poses equal, latency {latency} clocks, {clocks_per_s:.0f} clocks/s")


def stream(verilog: list[Path], name: str, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Results (k, 6) and clocks of acceptance (k,), as tb/gates/core_bench.cpp writes them, and clocks per second."""
    program = verilate(verilog, "gc_core", ROOT / "tb" / "gates" / "core_bench.cpp", name)
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
