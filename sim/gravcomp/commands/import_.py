"""Convert a public data set of a real machine to the measured CSV.

emps: DATA_EMPS.mat; anticogging: stopped_data.txt. The header of the CSV states filtering and differentiation.
"""

from pathlib import Path

from gravcomp.files import write_atomically
from gravcomp.logs.importers import IMPORTERS, convert


def add_arguments(parser):
    parser.add_argument("kind", choices=IMPORTERS, help="which data set")
    parser.add_argument("data", type=Path, help="the file as published")
    parser.add_argument("--out", type=Path, required=True, help="CSV to write")


def run(arguments):
    text = convert(arguments.kind, arguments.data)
    write_atomically(arguments.out, text)
    print(f"{arguments.out}: {sum(not line.startswith('#') for line in text.splitlines()) - 1} samples")
