"""Write test vectors of the core: encoder counts, and the forces that its bit-true model answers with.

One line per inference: the count of each axis, then the force of each axis in mN. gc_vectors_bench.vhd, in any
simulator, compares the VHDL with them. Half of the counts lie in the trained range, the rest anywhere in 32 bits, the
extremes among them, where the core clamps.
"""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")
    parser.add_argument("--out", type=Path, required=True, help="text file to write")
    parser.add_argument("--number", type=int, default=500, help="lines (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of the counts (default %(default)s)")


def run(arguments):
    from gravcomp.core.folder import load_folder
    from gravcomp.core.quantised import quantised
    from gravcomp.twin.vectors import random_vectors

    if arguments.number < 1 or arguments.seed < 0:
        raise InputError("--number must be at least 1 and --seed at least 0; correct them")
    content = load_folder(arguments.weights)
    fixed = quantised(content.machine, content.network, arguments.weights)
    rows = random_vectors(fixed, arguments.number, arguments.seed)
    write_atomically(arguments.out, "".join(" ".join(map(str, row)) + "\n" for row in rows))
    print(f"{arguments.out}: {len(rows)} inferences of {arguments.weights}, seed {arguments.seed}")
