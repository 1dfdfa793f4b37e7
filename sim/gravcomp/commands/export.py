"""Write friction and cogging of a machine folder as tables for drives: CSV, YAML, moteus, ODrive, Beckhoff.

Every effort is what the drive has to add, positive along +q: N or Nm at the axis (csv, yaml), Nm or A at the motor.
docs/guide/export.md tells what each drive does with its file.
"""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically


def add_arguments(parser):
    parser.add_argument("kind", choices=("csv", "yaml", "moteus", "odrive", "beckhoff"), help="of the files")
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="where to write")
    for name, what in (
        ("turn", "travel of each axis per turn of its motor, m or rad, negative if it runs against it "
                 "(default: one turn of a rotary axis)"),
        ("zero", "position of each axis where its motor's encoder reads 0, m or rad (default 0)"),
        ("speed", "largest speed of each axis, m/s or rad/s (default: v_max of compensation.csv)"),
    ):  # fmt: skip
        parser.add_argument(f"--{name}", nargs="+", type=float, metavar="VALUE", help=what)
    parser.add_argument("--current-unit", type=float, default=1.0, metavar="AMPERE",
                        help="beckhoff: amperes in one unit of the drive's torque (default 1)")  # fmt: skip


def run(arguments):
    from gravcomp.export.formats import KINDS, left_out, read_order

    kind = arguments.kind
    order = read_order(arguments.weights, arguments.turn, arguments.zero, arguments.speed, arguments.current_unit)
    files = KINDS[kind](order)
    notes = left_out(order, kind)
    if not files:
        raise InputError(f"{arguments.weights}: has no cogging, and {notes[0]}; take csv or yaml")
    write_all_atomically({arguments.out / name: text for name, text in files.items()})
    for line in [*(f"{arguments.out / name}: written from {arguments.weights}" for name in files), *notes]:
        print(line)
