"""Simulate gc_force_path from its encoder pins over poses of the workspace; print its errors, draw its pictures."""

from pathlib import Path

from tqdm import tqdm

from gravcomp.core.compensator_tables import quantise_compensation
from gravcomp.core.folder import load_folder
from gravcomp.core.formats import FORCE_BITS
from gravcomp.core.quantised import quantised
from gravcomp.errors import InputError
from gravcomp_lab.benches.force_path import motion_run, pose_run
from gravcomp_lab.simulated.pictures import error_picture, run_picture, save_figure
from gravcomp_lab.simulated.run import error_table


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="machine folder of the ROM")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--build", type=Path, default=Path("build/sim"), help="folder of the simulations")
    parser.add_argument("--pictures", type=Path, help="folder of the pictures (default: that of the simulations)")


def run(arguments):
    content, build = load_folder(arguments.weights), arguments.build
    machine = content.machine
    fixed = quantised(machine, content.network, arguments.weights)
    compensation = quantise_compensation(content.compensation, machine.drive, arguments.weights)
    vcd, folder = build / "run.vcd", arguments.pictures or build
    with tqdm(total=2, desc="simulations", leave=False, disable=None) as bar:
        motion = motion_run(arguments.rtl, build, arguments.weights, vcd)
        bar.update()
        poses = pose_run(arguments.rtl, build, arguments.weights)
    save_figure(run_picture(vcd, fixed.n_axes, FORCE_BITS, machine.effort_unit), folder / "run.png")
    save_figure(error_picture(fixed, machine), folder / "error_maps.png")
    print("Simulated VHDL (gc_force_path, from its encoder pins) against the bit-true model and the statics; E is the")
    print("error of a pose against the statics, a vector over the axes, F the statics' forces:\n")
    print(error_table(poses, fixed, compensation, machine))
    print(f"\nPictures: {folder / 'run.png'}, {folder / 'error_maps.png'}; waveform: {vcd}")
    if any(run.lsb(fixed, compensation).any() for run in (poses, motion)):
        raise InputError("the VHDL is not bit for bit the model; `make rom` writes its ROM from these weights")
