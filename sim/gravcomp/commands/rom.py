"""Write the VHDL packages of a network and its compensator from a weights folder."""

from pathlib import Path

from gravcomp.network.rom import PACKAGE_FILE, write_rom
from gravcomp.robot.parameters import NOMINAL_TOML, load_parameters


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="folder of CSV files")
    parser.add_argument("--robot", type=Path, default=NOMINAL_TOML, help="robot parameters (encoder, thrust constant)")
    parser.add_argument("--out", type=Path, default=Path("rtl/generated"), help="folder of the packages")


def run(arguments):
    fixed = write_rom(arguments.weights, load_parameters(arguments.robot), arguments.out)
    print(f"{arguments.out / PACKAGE_FILE}: {fixed.n_axes}-{fixed.n_hidden}-{fixed.n_axes} from {arguments.weights}")
