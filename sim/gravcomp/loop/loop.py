"""The loop: what a diagnosis found goes into network and compensator, and held-out samples judge model and hardware.

Folder of a loop: before/ and after/, each with weights/ (a weights folder), generated/ (VHDL packages) and, once the
RTL has run, rtl_mn.npy; samples.npz, what the RTL is to be run on and what was measured there.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gravcomp.core.compensation import Compensation, load_compensation, no_compensation, save_compensation
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report import errors
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.placement import DEFAULT_CLOCK_HZ, Placement, into_hardware
from gravcomp.network.weights import Network, load_network, save_network
from gravcomp.robot.spheiro.parameters import RobotParameters
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
    """Raise InputError unless data are of the built-in robot and the weights have its axes."""
    n_axes = load_network(weights).n_axes
    if data.robot is None or n_axes != data.n_axes:
        raise InputError(f"{data.name}: not of the robot of {weights}; give its positions q1_m .., without fm columns")


def close_loop(found: Diagnosis, model: Model, weights: Path, folder: Path, seed: int) -> Closed:
    """Put the model, with what was found, into weights and constants; writes before/ and after/ with their ROMs, and
    samples.npz.

    Empirical corrections that depend on positions alone go into the network too. Raises InputError for effects that
    the hardware cannot hold.
    """
    network, p = load_network(weights), model.robot
    grown, placement, corrections = into_hardware(model, found.data, network, seed)
    _write(folder, "before", network, load_compensation(weights, network.n_axes), p, f"from {weights}")
    names = ", ".join(placement.in_compensator) or "nothing"
    _write(folder, "after", grown, placement.compensation, p, f"found in {found.data.name}: {names}")
    n_samples = save_samples(found, folder, p)
    return Closed(placement, corrections, n_samples)


def _write(folder: Path, run: str, network: Network, constants: Compensation, p: RobotParameters, comment: str) -> None:
    save_network(network, weights_folder(folder, run))
    save_compensation(constants, weights_folder(folder, run), comment)
    write_rom(weights_folder(folder, run), p, generated_folder(folder, run))
    answer_file(folder, run).unlink(missing_ok=True)


def save_samples(found: Diagnosis, folder: Path, p: RobotParameters) -> int:
    """Write samples.npz: at most MAX_RTL_SAMPLES held-out samples, evenly chosen; returns how many.

    count, period (N, n): what the RTL reads; a hold has the speed of its approach. q_m, v_mps, measured_n, model_n,
    found_n (N, n): as measured, by the analytic model, and by it with all that was found.
    """
    data, rows = found.data, np.flatnonzero(found.is_test)
    rows = rows[:: -(-len(rows) // MAX_RTL_SAMPLES)]
    v_mps = (np.zeros_like(data.q) if data.v is None else data.v)[rows]
    clock = replace(no_compensation(data.n_axes), clock_hz=np.full(data.n_axes, DEFAULT_CLOCK_HZ))
    np.savez(
        folder / SAMPLES,
        count=np.rint(data.q[rows] / p.encoder_m_per_count).astype(np.int64),
        period=period_of(v_mps, clock, p),
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
        raise InputError(f"{error.filename}: not found; run `make loop`, which makes it") from error
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
    return force_n + constants.corrections_n(samples["q_m"], samples["v_mps"], force_n)
