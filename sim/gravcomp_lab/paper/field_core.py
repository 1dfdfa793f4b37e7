"""The core after the loop: what was found in measured data, brought into network and compensator of the hardware."""

from dataclasses import dataclass

import numpy as np

from gravcomp.core.compensation import Compensation
from gravcomp.core.compensator_tables import FixedCompensation, quantise_compensation
from gravcomp.core.formats import FixedNetwork, quantise
from gravcomp.diagnosis.fit import Fit
from gravcomp.diagnosis.model import Model
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.placement import into_hardware
from gravcomp.network.weights import Network
from gravcomp.robot.machine import Drive, Machine
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator, period_of


@dataclass(frozen=True)
class FieldCore:
    """Integers of network and compensator; forces() are those of the bit-true models."""

    network: FixedNetwork
    constants: Compensation
    compensation: FixedCompensation
    drive: Drive

    def forces(self, data: Measurement) -> np.ndarray:
        """Forces (n, 3), N, at the counts of data.q and the speed meter's periods at steady speeds data.v."""
        count = self.drive.counts(data.q)
        period = period_of(data.v, self.drive)
        force_mn, _ = compensator(bittrue.core(count, self.network).force_mn, count, period, self.compensation)
        return 1e-3 * force_mn


def build_core(fit: Fit, field: Measurement, start: Network, machine: Machine, n_poses: int, seed: int) -> FieldCore:
    """start with what the fit found in the field, as in the loop; n_poses to train on again."""
    network, placement, _ = into_hardware(Model(machine).grown(fit), field, start, seed, n_poses)
    constants = placement.compensation
    drive = machine.drive
    return FieldCore(quantise(network, drive), constants, quantise_compensation(constants, drive), drive)
