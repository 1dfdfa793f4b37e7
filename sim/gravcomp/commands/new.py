"""Write a project folder: a machine, the RTL with its ROM, the C driver, a Makefile, scripts for the vendors' tools.

FOLDER must be absent or empty. --robot takes a machine folder, or the name of a machine that is built in: spheiro,
which has a network, or a robot to begin from: slide, arm2, fivebar, ur5, so101.
"""

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="project folder to write")
    parser.add_argument("--robot", required=True, metavar="MACHINE", help="machine folder, or a name")


def run(arguments):
    from gravcomp.project.project import MACHINE, machine_named, write_project

    machine = machine_named(arguments.robot)
    cost = write_project(arguments.folder, machine)
    print(f"{arguments.folder}: written; {MACHINE} in it is {machine}")
    if cost:
        print(f"  with its ROM: {cost}; next: cd {arguments.folder} && make test")
    else:
        print(f"  it has no network yet; next: cd {arguments.folder}, correct {MACHINE}/robot.toml, make train test")
