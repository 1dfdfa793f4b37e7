"""The loop: what a diagnosis found goes into network and compensator, and held-out samples judge model and hardware.

Folder of a loop: before/ and after/, each with weights/ (a machine folder), generated/ (VHDL packages) and, once the
RTL has run, rtl_mn.npy; samples.npz, what the RTL is to be run on and what was measured there.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core.compensation import load_compensation
from gravcomp.core.folder import MachineFolder, load_folder, save_folder
from gravcomp.core.provenance import PROVENANCE_JSON, provenance_text
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
from gravcomp.twin.compensator import period_of

RUNS = ("before", "after")
SAMPLES = "samples.npz"
# More would take the simulator minutes: it runs about a hundred samples a second.
MAX_RTL_SAMPLES = 500


@dataclass(frozen=True)
class Closed:
    """A closed loop: where the effects went, the empirical corrections that the network took, samples for the RTL."""

    placement: Placement
    corrections: list[str]
    n_samples: int


def weights_folder(folder: Path, run: str) -> Path:
    return folder / run / "weights"


def generated_folder(folder: Path, run: str) -> Path:
    return folder / run / "generated"


def answer_file(folder: Path, run: str) -> Path:
    """Forces of the RTL at the samples, mN (N, n)."""
    return folder / run / "rtl_mn.npy"


def check_robot(data: Measurement, weights: Path) -> None:
    """Raise InputError unless data are of the robot in the machine folder weights."""
    if data.robot is None:
        units = load_machine(weights).position_units
        wanted = ", ".join(f"q{k}_{unit}" for k, unit in enumerate(units, start=1))
        raise InputError(f"{data.name}: not of the robot of {weights}; give its positions {wanted}, without fm columns")


def close_loop(
    found: Diagnosis, model: Model, weights: Path, folder: Path, seed: int, command: str, log: dict
) -> Closed:
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
    return Closed(placement, corrections, n_samples)


def _write(folder: Path, run: str, content: MachineFolder, comment: str, provenance: str) -> None:
    target = weights_folder(folder, run)
    save_folder(target, content, comment)
    write_atomically(target / PROVENANCE_JSON, provenance)
    write_rom(target, generated_folder(folder, run))
    answer_file(folder, run).unlink(missing_ok=True)


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


def error_table(folder: Path) -> dict[str, dict[str, dict[str, float]]]:
    """Errors as in a report by model (analytic model, network, RTL) and run (before, after), on the samples of a loop.

    Raises InputError when the loop or its RTL run is missing.
    """
    try:
        with np.load(folder / SAMPLES) as file:
            samples = dict(file)
        rtl_n = {run: np.load(answer_file(folder, run)) / 1000.0 for run in RUNS}
    except OSError as error:
        raise InputError(f"{error.filename}: not found; `make loop` in a clone makes it") from error
    forces = {
        "analytic model": {"before": samples["model_n"], "after": samples["found_n"]},
        "network": {run: _network_forces(folder, run, samples) for run in RUNS},
        "RTL": rtl_n,
    }
    measured_n = samples["measured_n"]
    return {
        name: {run: errors(force_n - measured_n, measured_n) for run, force_n in runs.items()}
        for name, runs in forces.items()
    }


def noise_floor_n(folder: Path) -> float:
    with np.load(folder / SAMPLES) as file:
        return float(file["noise_n"])


def _network_forces(folder: Path, run: str, samples: dict[str, np.ndarray]) -> np.ndarray:
    network = load_network(weights_folder(folder, run))
    constants = load_compensation(weights_folder(folder, run), network.n_axes)
    force_n = network.forces(samples["q_m"])
    return force_n + constants.corrections(samples["q_m"], samples["v_mps"], force_n)
