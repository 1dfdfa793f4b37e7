"""The paper's Table 2 repeated on the virtual prototype, and the rows that the paper does not have.

100 holds train the network and feed the diagnosis; the errors are those on other holds, at torsion 0 and 15 deg.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from gravcomp.diagnosis.diagnosis import Diagnosis, diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.logs.measurement import Measurement
from gravcomp.network.weights import Network
from gravcomp.parallel import one_blas_thread
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp.robot.spheiro.workspace import sample_workspace
from gravcomp_lab.paper.field import APPROACHES, hold_field, move_field, true_forces
from gravcomp_lab.paper.field_core import FieldCore, build_core
from gravcomp_lab.paper.fine_tuning import WAYS, Tuned, tune_by_validation
from gravcomp_lab.simulated.statistics import ForceError, force_error

TORSIONS_DEG = (0, 15)
FIELD, SIMULATION, ANALYTIC = "network, trained on the field", "network, trained in simulation", "analytic model"
HOLDS, MOTION = "the training holds", "slow motion"
TRUTH = f"{ANALYTIC} + the prototype's own effects"
# Maximum and average error in percent at each torsion, as printed in the paper.
PAPER = {
    FIELD: {0: (7.0, 2.8), 15: (11.5, 4.6)},
    SIMULATION: {0: (9.0, 3.8), 15: (13.6, 4.9)},
    ANALYTIC: {0: (8.5, 3.8), 15: (12.6, 5.4)},
}


@dataclass(frozen=True)
class SampleCounts:
    """Holds for training, test holds per torsion, samples of the slow motion, poses of the retraining."""

    training: int = 100
    test: int = 200
    motion: int = 800
    retraining: int = 1500


@dataclass(frozen=True)
class PrototypeTable:
    """errors[approach][row][torsion]; tuned[approach]: both ways of training on the field, the chosen one first;
    found: what was diagnosed, by source; cores: the cores after the loop, by source. A source is an approach's holds
    (approach, HOLDS) or the motion (MOTION,)."""

    errors: dict[str, dict[str, dict[int, ForceError]]]
    tuned: dict[str, list[Tuned]]
    found: dict[tuple[str, ...], Diagnosis]
    cores: dict[tuple[str, ...], FieldCore]


def found_row(source: str) -> str:
    return f"{ANALYTIC} + effects found in {source}"


def core_row(source: str) -> str:
    return f"core after the loop, effects found in {source}"


def table2(machine: Machine, simulated: Network, seed: int, sizes: SampleCounts = SampleCounts()) -> PrototypeTable:
    """Measure, train, diagnose and compare. simulated: the network trained in simulation."""
    seeds = iter(np.random.SeedSequence(seed).generate_state(40).tolist())
    table = PrototypeTable({}, {}, {}, {})
    motion = move_field(machine, sizes.motion, next(seeds))
    sets = {approach: _holds(machine, approach, sizes, seeds) for approach in APPROACHES}
    with tqdm(total=1 + 2 * len(sets), desc="training and diagnosis", delay=2.0) as progress:
        _diagnose((MOTION,), motion, simulated, machine, sizes, seed, table)
        progress.update()
        for approach, (training, tests) in sets.items():
            tuned = [tune_by_validation(simulated, training.q, training.force, way, seed) for way in WAYS]
            table.tuned[approach] = sorted(tuned, key=lambda t: t.validation_rms_n)
            progress.update()
            _diagnose((approach, HOLDS), training, simulated, machine, sizes, seed, table)
            progress.update()
            rows = _rows(simulated, approach, table)
            table.errors[approach] = {
                name: {torsion: force_error(forces(test), test.force) for torsion, test in tests.items()}
                for name, forces in rows.items()
            }
    return table


def _holds(machine: Machine, approach: str, sizes: SampleCounts, seeds) -> tuple[Measurement, dict[int, Measurement]]:
    p = spheiro_of(machine)
    training = hold_field(machine, sample_workspace(sizes.training, p, next(seeds)), approach, next(seeds))
    tests = {
        torsion: hold_field(
            machine, sample_workspace(sizes.test, p, next(seeds), torsion_deg=torsion), approach, next(seeds)
        )
        for torsion in TORSIONS_DEG
    }
    return training, tests


def _diagnose(
    source, data: Measurement, simulated: Network, machine, sizes: SampleCounts, seed: int, table: PrototypeTable
) -> None:
    with one_blas_thread():
        found = table.found[source] = diagnose(data, Model(machine), seed)
    table.cores[source] = build_core(found.fit, data, simulated, machine, sizes.retraining, seed)


def _rows(simulated: Network, approach: str, table: PrototypeTable) -> dict[str, Callable[[Measurement], np.ndarray]]:
    """Each row's forces (n, 3), N, for a measurement."""
    rows = {
        FIELD: lambda data: table.tuned[approach][0].network.forces(data.q),
        SIMULATION: lambda data: simulated.forces(data.q),
        ANALYTIC: lambda data: data.nominal,
    }
    for name, source in ((HOLDS, (approach, HOLDS)), (MOTION, (MOTION,))):
        fit, core = table.found[source].fit, table.cores[source]
        rows[found_row(name)] = lambda data, fit=fit: data.nominal + fit.predict(data)
        rows[core_row(name)] = core.forces
    return rows | {TRUTH: true_forces}


def markdown(table: PrototypeTable) -> str:
    """The table, the paper's figures beside ours."""
    head = [
        "model",
        "torsion",
        "paper max",
        "paper ave",
        *(f"{a} {kind}" for a in table.errors for kind in ("max", "ave")),
    ]
    lines = [f"| {' | '.join(head)} |", "|--|" + "--:|" * (len(head) - 1)]
    for name in next(iter(table.errors.values())):
        for torsion in TORSIONS_DEG:
            paper = [f"{value:.1f}" for value in PAPER[name][torsion]] if name in PAPER else ["", ""]
            errors = [by_row[name][torsion] for by_row in table.errors.values()]
            figures = [text for e in errors for text in (f"{e.max_percent:.1f}", f"{e.average_percent:.2f}")]
            lines.append(f"| {' | '.join([name, f'{torsion}°', *paper, *figures])} |")
    return "\n".join(lines) + "\n"


def findings(table: PrototypeTable) -> str:
    """What training and diagnosis chose, as Markdown lists."""
    lines = ["Ways of training on the field, RMS error in cross-validation (the first one is reported):", ""]
    for approach, tuned in table.tuned.items():
        both = "; ".join(f"{t.way}, ridge {t.ridge:g}: {t.validation_rms_n:.2f} N" for t in tuned)
        lines.append(f"- approach {approach}: {both}")
    lines += ["", "What the diagnosis found:", ""]
    for source, found in table.found.items():
        effects = "; ".join(f"{e.name} ({_values(e.parameters)})" for e in found.fit.effects) or "no effect"
        corrections = f"; {len(found.fit.corrections)} empirical corrections" if found.fit.corrections else ""
        alike = "".join(f"; cannot tell apart: {', '.join(names)}" for names in found.alternatives)
        lines.append(f"- {', '.join(source)}: {found.verdict}: {effects}{corrections}{alike}")
    return "\n".join(lines) + "\n"


def _values(parameters: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.3g}" for name, value in parameters.items())
