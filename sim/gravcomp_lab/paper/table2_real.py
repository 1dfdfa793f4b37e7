"""The paper's Table 2 on a real machine: static holds of the master arm of a da Vinci Research Kit.

Some holds teach, all others judge; every model runs as the bit-true core would run it. A percentage is
100 |E|/|F_exp| per hold, norms over the joints; beside it, as holds of hardly any effort have large ones, that in
percent of the RMS effort.
"""

import io
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from gravcomp.core.compensation import no_compensation
from gravcomp.core.compensator_tables import quantise_compensation
from gravcomp.core.formats import quantise
from gravcomp.diagnosis.diagnosis import Diagnosis, diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.measurement import Measurement
from gravcomp.network.weights import Network
from gravcomp.parallel import one_blas_thread
from gravcomp.robot.machine import Machine
from gravcomp.training.search import random_hidden
from gravcomp.training.training import Effort, train, workspace_set
from gravcomp_lab.paper.field_core import FieldCore, build_core
from gravcomp_lab.paper.fine_tuning import fine_tune, tune_by_validation
from gravcomp_lab.paper.table2 import ANALYTIC, FIELD, PAPER, SIMULATION

HOLDS = Path("dvrk_mtm") / "holds.csv"
TUNED, FOUND = f"{SIMULATION}, tuned on the field", f"{ANALYTIC} + effects found"
COUNTS = (25, 50, 100, 200, 400, 800, 1600, 3000)
TABLE_COUNT = 100
N_HIDDEN = 20  # as in the paper
_WAY, _VALIDATED = "all weights", 200  # holds: more cost minutes and move the ridge by less than its grid
_POSES = 1500  # of the workspace, for networks of the statics
_LIGHT = Effort(draws=6, tied_hops=4, hops=8)


@dataclass(frozen=True)
class Errors:
    """Of efforts on holds that taught nothing: norms over the joints in percent of each hold's effort, and RMS, Nm."""

    max_percent: float
    average_percent: float
    max_of_rms: float
    average_of_rms: float
    rms_nm: float


@dataclass(frozen=True)
class RealTable:
    """errors[number of holds][row]; found: the diagnosis by number; sizes[row]: |E| of the table's holds, Nm, by test
    row; test: those holds."""

    errors: dict[int, dict[str, Errors]]
    found: dict[int, Diagnosis]
    sizes: dict[str, np.ndarray]
    test: Measurement


def read_holds(folder: Path, machine: Machine) -> Measurement:
    """The public log as the arm's machine reads it. Raises InputError where the folder or the log is not there."""
    path = folder / HOLDS
    if not path.is_file():
        raise InputError(f"{path}: not found; give the folder of the measured data, its {HOLDS} is a public log")
    data = read_measurement(path)
    robot = machine.robot
    return replace(data, robot=robot, force_at=robot.forces, nominal=robot.forces(data.q))


def errors_of(force_nm: np.ndarray, measured_nm: np.ndarray) -> Errors:
    """Efforts (n, k) against the measured ones."""
    size, effort = (np.linalg.norm(x, axis=1) for x in (force_nm - measured_nm, measured_nm))
    percent, of_rms = 100.0 * size / effort, 100.0 * size / np.sqrt(np.mean(effort**2))
    rms = float(np.sqrt(np.mean((force_nm - measured_nm) ** 2)))
    return Errors(*(float(x) for x in (percent.max(), percent.mean(), of_rms.max(), of_rms.mean())), rms)


def table2_real(
    machine: Machine, data: Measurement, seed: int, counts=COUNTS, table_count: int = TABLE_COUNT
) -> RealTable:
    """Train, diagnose and compare. Holds that teach are drawn by seed; fewer are part of more."""
    order = np.random.default_rng(seed).permutation(len(data.t_s))
    simulated = _of_statics(machine, seed)
    untaught = _untaught(simulated, data, order[:table_count], seed)
    table = RealTable({}, {}, {}, rows_of(data, np.sort(order[table_count:])))
    for count in tqdm(counts, desc="holds", delay=2.0):
        field, test = (rows_of(data, np.sort(rows)) for rows in (order[:count], order[count:]))
        with one_blas_thread():
            found = table.found[count] = diagnose(field, Model(machine), seed)
        cores = {
            ANALYTIC: plain_core(simulated, machine),
            FIELD: plain_core(_taught(untaught, field, seed), machine),
            TUNED: plain_core(_taught(simulated, field, seed), machine),
            FOUND: build_core(found.fit, field, simulated, machine, _POSES, seed),
        }
        forces = {name: core.forces(test) for name, core in cores.items()}
        table.errors[count] = {name: errors_of(force, test.force) for name, force in forces.items()}
        if count == table_count:
            table.sizes.update({name: np.linalg.norm(f - test.force, axis=1) for name, f in forces.items()})
    return table


def rows_of(data: Measurement, rows: np.ndarray) -> Measurement:
    """Some rows of a log without runs."""
    return replace(
        data, t_s=data.t_s[rows], q=data.q[rows], v=data.v[rows], force=data.force[rows], nominal=data.nominal[rows]
    )


def plain_core(network: Network, machine: Machine) -> FieldCore:
    """The core with this network and nothing in the compensator."""
    none, drive = no_compensation(machine.n_axes), machine.drive
    return FieldCore(quantise(network, drive), none, quantise_compensation(none, drive), drive)


def _of_statics(machine: Machine, seed: int) -> Network:
    data = workspace_set(_POSES, machine.robot, seed)
    return train(data, machine, n_hidden=N_HIDDEN, n_starts=1, seed=seed, backend="threading", effort=_LIGHT)[0]


def _untaught(like: Network, data: Measurement, rows: np.ndarray, seed: int) -> Network:
    """Random neurons that say the mean effort of some holds, with their spread as the scale of the efforts."""
    hidden = random_hidden(like.n_hidden, like.n_axes, np.random.default_rng(seed))
    mean, scale = data.force[rows].mean(axis=0), 3.0 * data.force[rows].std(axis=0)
    return replace(like, hidden_weights=hidden[:, :-1], hidden_bias=hidden[:, -1], f_offset=mean, f_scale=scale,
                   output_weights=0.0 * like.output_weights, output_bias=0.0 * like.output_bias)  # fmt: skip


def _taught(start: Network, field: Measurement, seed: int) -> Network:
    """Trained on the holds, held near its start by a ridge that cross-validation on some of them chooses."""
    few = slice(0, _VALIDATED)
    tuned = tune_by_validation(start, field.q[few], field.force[few], _WAY, seed)
    if len(field.q) <= _VALIDATED:
        return tuned.network
    with one_blas_thread():
        return fine_tune(start, field.q, field.force, tuned.ridge, _WAY)


def markdown(table: RealTable, count: int = TABLE_COUNT) -> str:
    """The table, the paper's figures at torsion 0 beside ours."""
    head = (
        "| model | paper max % | paper ave % | max % | ave % | max, % of RMS effort | ave, % of RMS effort | RMS mNm |"
    )
    lines = [head, "|--|" + "--:|" * 7]
    for name, e in table.errors[count].items():
        paper = [f"{value:.1f}" for value in PAPER[name][0]] if name in PAPER else ["", ""]
        ours = [f"{e.max_percent:.0f}", f"{e.average_percent:.1f}", f"{e.max_of_rms:.1f}", f"{e.average_of_rms:.2f}"]
        lines.append(f"| {' | '.join([name, *paper, *ours, f'{1e3 * e.rms_nm:.1f}'])} |")
    return "\n".join(lines) + "\n"


def curve(table: RealTable) -> str:
    """Average error, in percent of the RMS effort, by number of holds."""
    names = list(next(reversed(table.errors.values())))
    lines = [f"| holds | {' | '.join(names)} |", "|--:|" + "--:|" * len(names)]
    for count, by_row in table.errors.items():
        cells = [f"{by_row[name].average_of_rms:.2f}" if name in by_row else "" for name in names]
        lines.append(f"| {count} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def findings(table: RealTable) -> str:
    """What the diagnosis named, by number of holds."""
    lines = []
    for count, found in table.found.items():
        names = ", ".join(entry.name for entry in found.fit.effects) or "no effect"
        lines.append(f"- {count} holds: {found.verdict}: {names}; {len(found.fit.corrections)} empirical corrections")
    return "\n".join(lines) + "\n"


def map_png(table: RealTable) -> bytes:
    """The paper's Figure 8: mean size of both errors, mNm, over the poses of two pairs of joints."""
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    panels = figure.subplots(2, 2)
    for row, name in zip(panels, (ANALYTIC, FOUND), strict=True):
        for panel, (a, b) in zip(row, ((1, 2), (3, 4)), strict=True):
            mean = _mean_by_pose(table.test.q[:, a], table.test.q[:, b], 1e3 * table.sizes[name])
            top = np.nanquantile(1e3 * table.sizes[ANALYTIC], 0.99)
            image = panel.imshow(mean.T, origin="lower", aspect="auto", vmin=0.0, vmax=top, cmap="viridis",
                                 extent=[f(table.test.q[:, i]) for i in (a, b) for f in (np.min, np.max)])  # fmt: skip
            panel.set(xlabel=f"q{a + 1} rad", ylabel=f"q{b + 1} rad", title=name)
    figure.colorbar(image, ax=panels, label="mean |E|, mNm")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def _mean_by_pose(x: np.ndarray, y: np.ndarray, size: np.ndarray, cells: int = 10) -> np.ndarray:
    """Means (cells, cells) over a grid of the ranges; nan where no hold is."""
    sums, _, _ = np.histogram2d(x, y, cells, weights=size)
    number, _, _ = np.histogram2d(x, y, cells)
    return np.divide(sums, number, out=np.full(sums.shape, np.nan), where=number > 0)
