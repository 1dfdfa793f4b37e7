"""Mean square against largest error of the Sphe.I.Ro.'s networks: rows of the two shipped ones, and the picture.

The other rows of docs/measured/largest_error.md are of networks that were not kept; the picture has them as they stand.
"""

import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter

from gravcomp.core.folder import load_folder
from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp_lab.pages import read, renew
from gravcomp_lab.shipped import ROOT

PAGE, PART, PICTURE = "largest_error.md", "largest error", "figures/largest_error.png"
SHIPPED = {
    "spheiro": "least mean square (`weights/spheiro`)",
    "spheiro_minimax": "**0.312, then 0.35, then 0.36 with `--norm 24`, pools drawn anew**",
}
SEEDS = 501, 502  # of the workspace, of its boundary
PAPER = 0.0263, 0.4  # N^2; N, as its figure shows


class Row(NamedTuple):
    """A network: what it was asked for, how; mean square in N^2 and largest error in N, inside and on the boundary."""

    asked: str
    how: str
    mean_square: float
    inside: float
    boundary: float


def add_arguments(parser):
    parser.add_argument("--poses", type=int, default=200000, help="of the workspace, and of its boundary")
    parser.add_argument("--docs", type=Path, help=f"folder whose {PAGE} and {PICTURE} are to be renewed")


def run(arguments):
    if arguments.poses < 1:
        raise InputError(f"--poses {arguments.poses}: give at least 1")
    docs = arguments.docs or ROOT / "docs" / "measured"
    rows = rows_of(read(docs / PAGE, PART))
    for name, asked in SHIPPED.items():
        (number,) = (k for k, row in enumerate(rows) if row.asked == asked)
        rows[number] = measured(ROOT / "weights" / name, rows[number], arguments.poses)
        print(text_of([rows[number]]).splitlines()[-1])
    if arguments.docs:
        renew(docs / PAGE, PART, text_of(rows))
        write_atomically(docs / PICTURE, picture(rows))


def measured(weights: Path, row: Row, n_poses: int) -> Row:
    """The row of a shipped network, over n_poses of the workspace and n_poses of its boundary."""
    content = load_folder(weights)
    robot, network = content.machine.robot, content.network
    inside, boundary = (network.forces(q) - robot.forces(q) for q in (
        robot.workspace(n_poses, SEEDS[0]), robot.boundary(n_poses, SEEDS[1])))  # fmt: skip
    largest = (float(np.abs(error).max()) for error in (inside, boundary))
    return Row(row.asked, row.how, float(np.mean(inside**2)), *largest)


def rows_of(table: str) -> list[Row]:
    """The rows of the page's table. Raises InputError for one that is not of it."""
    rows = []
    for line in table.splitlines()[2:]:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        try:
            rows.append(Row(*cells[:2], *map(float, cells[2:])))
        except (ValueError, TypeError):
            raise InputError(
                f"{PAGE}: {line!r} is no row of asked, how, mean square and two errors; correct it"
            ) from None
    return rows


def text_of(rows: list[Row]) -> str:
    lines = [
        "| asked for, N | poses, hops | mean square, N² | largest inside, N | largest on the boundary, N |",
        "|---|" + "---|" * 4,
    ]
    lines += [
        f"| {row.asked} | {row.how} | {row.mean_square:.4f} | {row.inside:.3f} | {row.boundary:.3f} |" for row in rows
    ]
    return "\n".join(lines)


def picture(rows: list[Row]) -> bytes:
    """Largest error against mean square, PNG: every network, the shipped ones and the paper's named."""
    figure = Figure(figsize=(7, 4.2), layout="constrained")
    axes = figure.subplots()
    largest = [max(row.inside, row.boundary) for row in rows]
    axes.loglog([row.mean_square for row in rows], largest, "o", color="tab:gray", label="trained, not kept")
    for name, asked in SHIPPED.items():
        (k,) = (k for k, row in enumerate(rows) if row.asked == asked)
        axes.loglog(rows[k].mean_square, largest[k], "o", markersize=9, label=f"weights/{name}")
    axes.loglog(*PAPER, "s", color="black", label="the paper, near the boundary")
    axes.set_xlabel("mean square error, N²")
    axes.set_ylabel("largest error, N")
    axes.grid(which="both", alpha=0.3)
    axes.legend()
    for axis, values in ((axes.xaxis, (0.004, 0.006, 0.01, 0.02)), (axes.yaxis, (0.3, 0.4, 0.6, 1.0, 1.5))):
        axis.set_major_locator(FixedLocator(values))
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_formatter(NullFormatter())
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()
