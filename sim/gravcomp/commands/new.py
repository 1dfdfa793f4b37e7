"""Write a project folder: a machine, the RTL with its ROM, the C driver, a Makefile, scripts for the vendors' tools.

FOLDER must be absent or empty. --robot takes a machine folder, or the name of a machine that is built in. --from takes
a URDF or MJCF: axes, ranges and units are read from it, and robot.toml asks by name for what it does not tell.
"""

import shlex
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.shipped import built_in


def add_arguments(parser):
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="project folder to write")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--robot", metavar="MACHINE", help=f"machine folder, or a name: {', '.join(built_in())}")
    source.add_argument("--from", dest="file", type=Path, metavar="ROBOT", help="URDF or MJCF")
    parser.add_argument(
        "--axes", default="", metavar="JOINTS", help="with --from: joints with a motor, by comma, in the core's order"
    )


def run(arguments):
    from gravcomp.project.project import MACHINE, machine_named, write_drafted_project, write_project

    place = shlex.quote(str(arguments.folder))
    if arguments.file:
        axes = arguments.axes.split(",") if arguments.axes else []
        asked = write_drafted_project(arguments.folder, arguments.file, axes)
        print(f"{arguments.folder}: written; {MACHINE} in it is {arguments.file}")
        print(f"  next: cd {place}, give {', '.join(asked)} in {MACHINE}/robot.toml, make train test")
        return
    if arguments.axes:
        raise InputError("--axes goes with --from; a machine folder has its axes in robot.toml")
    machine = machine_named(arguments.robot)
    cost = write_project(arguments.folder, machine)
    print(f"{arguments.folder}: written; {MACHINE} in it is {machine}")
    if cost:
        print(f"  with its ROM: {cost}; next: cd {place} && make test")
    else:
        print(f"  it has no network yet; next: cd {place}, correct {MACHINE}/robot.toml, make train test")
