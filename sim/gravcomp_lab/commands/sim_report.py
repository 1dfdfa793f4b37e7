"""Print the error table of the last simulated run and draw its pictures."""

from pathlib import Path

from gravcomp.core.formats import FORCE_BITS, quantise
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp_lab.simulated.pictures import error_maps, run_picture, save_figure
from gravcomp_lab.simulated.run import error_table, load_run


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="weights folder of the ROM")
    parser.add_argument("--pictures", type=Path, help="folder of the pictures (default: that of the run)")
    parser.add_argument("--run", type=Path, default=Path("build/sim"), help="folder that the simulation wrote")


def run(arguments):
    machine = load_machine(arguments.weights)
    fixed = quantise(load_network(arguments.weights), machine.drive, arguments.weights)
    table = error_table(load_run(arguments.run / "poses.csv"), fixed, machine)
    waves = run_picture(arguments.run / "run.vcd", fixed.n_axes, FORCE_BITS)
    folder = arguments.pictures or arguments.run
    save_figure(error_maps(fixed, machine), folder / "error_maps.png")
    save_figure(waves, folder / "run.png")
    print("Simulated VHDL (gc_force_path, from its encoder pins) against the bit-true model and the statics; E is the")
    print("error of a pose against the statics, a vector over the axes, F the statics' forces:\n")
    print(table)
    print(f"\nPictures: {folder / 'run.png'}, {folder / 'error_maps.png'}; waveform: {arguments.run / 'run.vcd'}")
