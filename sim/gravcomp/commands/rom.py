"""Write the VHDL packages of a network and its compensator from a weights folder."""

from pathlib import Path

from gravcomp.core.vhdl.network_package import stale_rom_files, write_rom
from gravcomp.errors import InputError
from gravcomp.robot.spheiro.parameters import NOMINAL_TOML, load_parameters


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="folder of CSV files")
    parser.add_argument("--robot", type=Path, default=NOMINAL_TOML, help="robot parameters (encoder, thrust constant)")
    parser.add_argument("--out", type=Path, default=Path("rtl/generated"), help="folder of the packages")
    parser.add_argument("--check", action="store_true", help="write nothing; complain if the packages are not these")


def run(arguments):
    p = load_parameters(arguments.robot)
    if not arguments.check:
        cost = write_rom(arguments.weights, p, arguments.out)
        print(f"{arguments.out}: written from {arguments.weights}; {cost}")
        return
    for path in stale_rom_files(arguments.weights, p, arguments.out):
        raise InputError(f"{path}: not made from {arguments.weights}; start `make rom WEIGHTS={arguments.weights}`")
