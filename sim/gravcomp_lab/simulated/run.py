"""What a simulated run left in build/sim: the answers of the core, pose by pose."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core.formats import FixedNetwork
from gravcomp.errors import InputError
from gravcomp.robot.machine import Machine
from gravcomp.twin import network as bittrue
from gravcomp_lab.simulated.statistics import force_error


@dataclass(frozen=True)
class Run:
    """set_name (k,), encoder counts (k, n) and the forces that the simulated VHDL answered (k, n), mN."""

    set_name: np.ndarray
    count: np.ndarray
    force_mn: np.ndarray


def load_run(path: Path) -> Run:
    """Read a CSV of the end-to-end simulation. Raises InputError when there is none, or it is not one."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        cells = np.array([line.split(",") for line in lines[1:]])
        n_axes = (cells.shape[1] - 1) // 2
        return Run(cells[:, 0], cells[:, 1 : 1 + n_axes].astype(np.int64), cells[:, 1 + n_axes :].astype(np.int64))
    except (OSError, ValueError, IndexError, OverflowError):
        raise InputError(f"{path}: no such run, or a damaged one; start `make sim` first") from None


def error_table(run: Run, fixed: FixedNetwork, machine: Machine) -> str:
    """Markdown table, a row per pose set: simulated forces against the bit-true model, LSB, and the statics, N.

    E: error of the forces of a pose against the statics, a vector over the axes; F: the statics' forces.
    """
    lines = [
        "| poses | number | against bit-true, LSB | mean of norm(E), N | RMS of E's components, N "
        "| largest component of E, N | average of norm(E)/norm(F), % | its maximum, % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in dict.fromkeys(run.set_name):
        chosen = run.set_name == name
        counts, force_mn = run.count[chosen], run.force_mn[chosen]
        lsb = np.abs(force_mn - bittrue.core(counts, fixed).force_mn).max()
        e = force_error(force_mn / 1000.0, machine.robot.forces(machine.drive.positions(counts)))
        lines.append(
            f"| {name} | {len(counts)} | {lsb} | {e.mean_n:.3f} | {e.rms_n:.3f} | {e.max_n:.3f} "
            f"| {e.average_percent:.2f} | {e.max_percent:.2f} |"
        )
    return "\n".join(lines)
