"""Write a project folder: a machine, the RTL with its ROM, the C driver, a Makefile, scripts for the vendors' tools.

FOLDER must be absent or empty. --robot takes a machine folder, or the name of a machine that is built in.
"""

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="project folder to write")
    parser.add_argument("--robot", required=True, metavar="MACHINE", help="machine folder, or a name: spheiro")


def run(arguments):
    from gravcomp.project.project import MACHINE, machine_named, write_project

    machine = machine_named(arguments.robot)
    cost = write_project(arguments.folder, machine)
    print(f"{arguments.folder}: written, with the ROM of {MACHINE}, copied from {machine}; {cost}")
    print(f"  cd {arguments.folder} && make")
