"""Write the VHDL packages of a network and its compensator from a machine folder."""

from pathlib import Path

from gravcomp.errors import InputError


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")
    parser.add_argument("--out", type=Path, default=Path("rtl/generated"), help="folder of the packages")
    parser.add_argument("--check", action="store_true", help="write nothing; complain if the packages are not these")


def run(arguments):
    from gravcomp.core.vhdl.network_package import stale_rom_files, write_rom
    from gravcomp.robot.machine import load_machine

    if not arguments.check:
        cost = write_rom(arguments.weights, arguments.out)
        print(f"{arguments.out}: written from {arguments.weights}; {cost}")
        for name, turns in load_machine(arguments.weights).turns_to_wrap().items():
            where = f"{turns:.4g} turns either way, and its phase jumps"
            print(f"  axis {name!r} has no limits: its count wraps after {where}; not with a power of two a turn")
        return
    for path in stale_rom_files(arguments.weights, arguments.out):
        raise InputError(f"{path}: not made from {arguments.weights}; start `make rom WEIGHTS={arguments.weights}`")
