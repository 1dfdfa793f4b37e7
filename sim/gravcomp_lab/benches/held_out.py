"""The held-out samples of a loop through gc_core and gc_compensator, with the ROM of before or of after."""

import os
from pathlib import Path

import cocotb
import numpy as np

from gravcomp.core.formats import COUNT_BITS, FORCE_BITS
from gravcomp.loop.loop import generated_folder, load_samples, weights_folder
from gravcomp.network.weights import load_network
from gravcomp.simulation.measured import hand_over
from gravcomp_lab.benches.bench import run_bench
from gravcomp_lab.benches.codes import pack, unpack
from gravcomp_lab.benches.stream import start, stream
from gravcomp_lab.shipped import ROOT

BENCH_SOURCE = ROOT / "tb" / "hdl" / "gc_force_bench.vhd"
PERIOD_BITS = 32


@cocotb.test()
async def held_out_samples(dut):
    """Every sample once, as fast as the core takes them."""
    samples = load_samples(Path(os.environ["LOOP"]))
    rows = zip(samples["count"], samples["period"], strict=True)
    inputs = [{"in_count": pack(count, COUNT_BITS), "in_period": pack(period, PERIOD_BITS)} for count, period in rows]
    await start(dut)
    got = await stream(dut, inputs, ["out_force"], has_ready=True)
    hand_over(force=got.outputs["out_force"])


def held_out_run(loop: Path, run: str, rtl: Path, build: Path) -> np.ndarray:
    """Forces (N, n) of the RTL at the samples of a loop's folder, mN or mNm; run: before or after."""
    network = load_network(weights_folder(loop, run))
    lanes = 1 if network.n_hidden % 4 else 4
    measured = run_bench(
        "gc_force_bench",
        __name__,
        lanes,
        rtl,
        build / f"held_out-{run}",
        {"LOOP": str(loop.absolute())},
        [BENCH_SOURCE],
        generated=generated_folder(loop, run),
    )
    return unpack(measured["force"], FORCE_BITS, network.n_axes)
