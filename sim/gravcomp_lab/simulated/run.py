"""A simulated run: the answers of the core, pose by pose."""

from dataclasses import dataclass

import numpy as np

from gravcomp.core.compensator_tables import FixedCompensation
from gravcomp.core.formats import FixedNetwork
from gravcomp.robot.machine import Machine
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp_lab.simulated.statistics import force_error


@dataclass(frozen=True)
class SimulatedRun:
    """set_name (k,); encoder counts, speeds as periods, and the forces that the VHDL answered, mN (k, n) each."""

    set_name: np.ndarray
    count: np.ndarray
    period: np.ndarray
    force_mn: np.ndarray

    def lsb(self, fixed: FixedNetwork, compensation: FixedCompensation) -> np.ndarray:
        """Distance of the forces from the bit-true model (k, n), LSB."""
        network_mn = bittrue.core(self.count, fixed).force_mn
        return np.abs(self.force_mn - compensator(network_mn, self.count, self.period, compensation)[0])


def error_table(run: SimulatedRun, fixed: FixedNetwork, compensation: FixedCompensation, machine: Machine) -> str:
    """Markdown table, a row per pose set: simulated forces against the bit-true model, LSB, and the statics, N or Nm.

    E: error of the forces of a pose against the statics, a vector over the axes; F: the statics' forces.
    """
    unit = machine.effort_unit
    lines = [
        f"| poses | number | against bit-true, LSB | mean of norm(E), {unit} | RMS of E's components, {unit} "
        f"| largest component of E, {unit} | average of norm(E)/norm(F), % | its maximum, % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in dict.fromkeys(run.set_name):
        chosen = run.set_name == name
        counts, force_mn = run.count[chosen], run.force_mn[chosen]
        lsb = run.lsb(fixed, compensation)[chosen].max()
        e = force_error(force_mn / 1000.0, machine.robot.forces(machine.drive.positions(counts)))
        lines.append(
            f"| {name} | {len(counts)} | {lsb} | {e.mean_n:.3f} | {e.rms_n:.3f} | {e.max_n:.3f} "
            f"| {e.average_percent:.2f} | {e.max_percent:.2f} |"
        )
    return "\n".join(lines)
