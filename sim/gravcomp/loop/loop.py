"""The loop: what a diagnosis found goes into network and compensator, and held-out samples judge model and hardware.

Folder of a loop: before/ and after/, each with weights/ (a machine folder) and generated/ (VHDL packages); samples.npz,
held-out samples for the hardware and what was measured there.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core.compensation import load_compensation
from gravcomp.core.compensator_tables import quantise_compensation
from gravcomp.core.folder import MachineFolder, load_folder, save_folder
from gravcomp.core.provenance import PROVENANCE_JSON, provenance_text
from gravcomp.core.quantised import quantised
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.model import Model, model_toml
from gravcomp.diagnosis.report.report import errors, report
from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.placement import Placement, into_hardware
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import ROBOT_TOML, Machine, load_machine, parse_machine
from gravcomp.twin.compensator import compensator, period_of
from gravcomp.twin.network import core

RUNS = ("before", "after")
SAMPLES = "samples.npz"
# More would take the simulator minutes: it runs about a hundred samples a second.
MAX_RTL_SAMPLES = 500


@dataclass(frozen=True)
class ClosedLoop:
    """A closed loop: where the effects went, the empirical corrections that the network took, samples for the RTL."""

    placement: Placement
    corrections: list[str]
    n_samples: int


def weights_folder(folder: Path, run: str) -> Path:
    return folder / run / "weights"


def generated_folder(folder: Path, run: str) -> Path:
    return folder / run / "generated"


def check_robot(data: Measurement, weights: Path) -> None:
    """Raise InputError unless data are of the robot in the machine folder weights."""
    if data.robot is None or data.is_predicted:
        units = load_machine(weights).position_units
        wanted = ", ".join(f"q{k}_{unit}" for k, unit in enumerate(units, start=1))
        raise InputError(f"{data.name}: not of the robot of {weights}; give its positions {wanted}, without fm columns")


def close_loop(
    found: Diagnosis, model: Model, weights: Path, folder: Path, seed: int, command: str, log: dict
) -> ClosedLoop:
    """Put the model, with what was found, into network and constants; writes before/ and after/ with their ROMs, and
    samples.npz.

    Empirical corrections that depend on positions alone go into the network too. command and log go into provenance.
    Raises InputError for effects that the hardware cannot hold.
    """
    start = load_folder(weights)
    network, placement, corrections = into_hardware(model, found.data, start.network, seed)
    grown = parse_machine(model_toml(model), str(weights / ROBOT_TOML))  # its files stand there
    _write(folder, "before", start, f"from {weights}", (weights / PROVENANCE_JSON).read_text(encoding="utf-8"))
    names = ", ".join(placement.in_compensator) or "nothing"
    result = MachineFolder(grown, network, placement.compensation)
    content = report(found)
    metrics = {f"model_{when}": content[when] for when in RUNS}
    provenance = provenance_text(command=command, data=log, metrics=metrics, machine=grown)
    _write(folder, "after", result, f"found in {found.data.name}: {names}", provenance)
    n_samples = save_samples(found, folder, start.machine)
    return ClosedLoop(placement, corrections, n_samples)


def _write(folder: Path, run: str, content: MachineFolder, comment: str, provenance: str) -> None:
    target = weights_folder(folder, run)
    save_folder(target, content, comment)
    write_atomically(target / PROVENANCE_JSON, provenance)
    write_rom(target, generated_folder(folder, run))


def save_samples(found: Diagnosis, folder: Path, machine: Machine) -> int:
    """Write samples.npz: at most MAX_RTL_SAMPLES held-out samples, evenly chosen; returns how many.

    count, period (N, n): what the RTL reads; a hold has the speed of its approach. q_m, v_mps, measured_n, model_n,
    found_n (N, n): as measured, by the analytic model, and by it with all that was found.
    """
    data, rows = found.data, np.flatnonzero(found.is_test)
    rows = rows[:: -(-len(rows) // MAX_RTL_SAMPLES)]
    v_mps = (np.zeros_like(data.q) if data.v is None else data.v)[rows]
    np.savez(
        folder / SAMPLES,
        count=machine.drive.counts(data.q[rows]),
        period=period_of(v_mps, machine.drive),
        q_m=data.q[rows],
        v_mps=v_mps,
        measured_n=data.force[rows],
        model_n=(data.force - found.before)[rows],
        found_n=(data.force - found.after)[rows],
        noise_n=found.noise_floor,
    )
    return len(rows)


def load_samples(folder: Path) -> dict[str, np.ndarray]:
    """What save_samples wrote into the folder of a loop. Raises InputError when it is missing."""
    try:
        with np.load(folder / SAMPLES) as file:
            return dict(file)
    except OSError as error:
        raise InputError(f"{folder / SAMPLES}: not found; `gravcomp loop --out {folder}` writes it") from error


def loop_errors(folder: Path) -> dict[str, dict[str, dict[str, float]]]:
    """Errors as in a report on the samples of a loop, by model and run: analytic model, network, and fixed point, which
    is the hardware bit by bit. Raises InputError when the loop is missing.
    """
    samples = load_samples(folder)
    forces = {
        "analytic model": {"before": samples["model_n"], "after": samples["found_n"]},
        "network": {run: _network_forces(folder, run, samples) for run in RUNS},
        "fixed point": {run: fixed_point_mn(folder, run, samples) / 1e3 for run in RUNS},
    }
    return {name: errors_by_run(runs, samples["measured_n"]) for name, runs in forces.items()}


def errors_by_run(forces: dict[str, np.ndarray], measured: np.ndarray) -> dict[str, dict[str, float]]:
    """Errors of the forces (N, n) of each run."""
    return {run: errors(force - measured, measured) for run, force in forces.items()}


def error_rows(table: dict[str, dict[str, dict[str, float]]]) -> str:
    """Rows of a Markdown table below ``error_head``, one for each model of ``loop_errors``."""
    cells = "{rms_n:.3f} | {max_n:.2f} | {ave_pct:.2f}"
    return "\n".join(
        f"| {name} | {' | '.join(cells.format(**runs[run]) for run in RUNS)} |" for name, runs in table.items()
    )


def error_head(unit: str) -> str:
    """Head of the table of errors of forces in a unit."""
    columns = [f"{run}: RMS, {unit} | max, {unit} | ave, %" for run in RUNS]
    return f"| held-out samples | {' | '.join(columns)} |\n|---|---|---|---|---|---|---|"


def _network_forces(folder: Path, run: str, samples: dict[str, np.ndarray]) -> np.ndarray:
    network = load_network(weights_folder(folder, run))
    constants = load_compensation(weights_folder(folder, run), network.n_axes)
    force_n = network.forces(samples["q_m"])
    return force_n + constants.corrections(samples["q_m"], samples["v_mps"], force_n)


def fixed_point_mn(folder: Path, run: str, samples: dict[str, np.ndarray]) -> np.ndarray:
    """Forces (N, n) of the hardware's bit-true twin at the samples of a loop, mN or mNm."""
    weights = weights_folder(folder, run)
    content, counts = load_folder(weights), samples["count"]
    drive = content.machine.drive
    force_mn = core(counts, quantised(content.machine, content.network, weights)).force_mn
    tables = quantise_compensation(content.compensation, drive, weights)
    return compensator(force_mn, counts, samples["period"], tables)[0]
