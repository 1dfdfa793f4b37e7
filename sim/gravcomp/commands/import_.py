"""Convert a file to the measured CSV: mat, mcap, mdf, parquet, rosbag, tdms, or a public data set of a real machine.

emps: DATA_EMPS.mat; anticogging: stopped_data.txt. Of the others every signal whose name is a column's is taken, and
what --columns says: q1_deg=SIGNAL, or q1=SIGNAL where the file tells the unit, or q_rad=ARRAY for all axes.
"""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.logs.importers import CONTAINERS, DATA_SETS, convert, convert_signals


def add_arguments(parser):
    parser.add_argument("kind", choices=sorted({*CONTAINERS, *DATA_SETS}), help="what the file is")
    parser.add_argument("data", type=Path, help="the file; of a rosbag its folder")
    parser.add_argument("--out", type=Path, required=True, help="CSV to write")
    parser.add_argument("--columns", nargs="+", default=[], metavar="COLUMN=SIGNAL",
                        help="which signal is which column: t_s=time q1_deg=Position1 f1_nm=Torque1")  # fmt: skip
    parser.add_argument("--dims", metavar="A,B,C", help="mat: the order of joint,pose,repeat in arrays of three")


def run(arguments):
    text = _converted(arguments.kind, arguments.data, arguments)
    write_atomically(arguments.out, text)
    print(f"{arguments.out}: {sum(not line.startswith('#') for line in text.splitlines()) - 1} samples")


def _converted(kind: str, path: Path, arguments) -> str:
    from gravcomp.logs.importers.signals import parse_columns

    columns = parse_columns(arguments.columns)
    if arguments.dims and kind != "mat":
        raise InputError(f"--dims: only a mat has arrays of three dimensions, not a {kind}; leave it out")
    if kind in DATA_SETS:
        if columns:
            raise InputError(f"--columns: {kind} has columns of its own; leave it out")
        return convert(kind, path)
    options = {"dimensions": tuple(arguments.dims.split(","))} if arguments.dims else {}
    return convert_signals(kind, path, columns, **options)
