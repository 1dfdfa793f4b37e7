"""Simulate the RTL on the held-out samples of `gravcomp loop`, before and after; print its errors.

Every force must equal that of the fixed-point model, bit by bit.
"""

from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.loop.loop import RUNS, error_rows, errors_by_run, fixed_point_mn, load_samples
from gravcomp_lab.benches.held_out import held_out_run


def add_arguments(parser):
    parser.add_argument("--loop", type=Path, default=Path("build/loop"), help="folder that loop wrote")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build"), help="folder of the simulations")


def run(arguments):
    samples, force_n = load_samples(arguments.loop), {}
    for name in tqdm(RUNS, desc="simulations", leave=False, disable=None):
        force_mn = held_out_run(arguments.loop, name, arguments.rtl, arguments.build)
        if (force_mn != fixed_point_mn(arguments.loop, name, samples)).any():
            raise InputError(
                f"{arguments.loop / name}: the VHDL is not bit for bit the model; `gravcomp loop` writes both"
            )
        force_n[name] = force_mn / 1e3
    print(error_rows({"RTL, equal to fixed point bit by bit": errors_by_run(force_n, samples["measured_n"])}))
