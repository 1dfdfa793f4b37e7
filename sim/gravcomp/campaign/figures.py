"""What the servo had to add to the core's feed-forward, from records, in newtons or newton metres."""

from dataclasses import dataclass

import numpy as np

from gravcomp.campaign.journal import Entry, joined
from gravcomp.campaign.measuring import RECORDS_OF_HOLD
from gravcomp.campaign.route import HOLD, Step
from gravcomp.diagnosis.report.report import errors
from gravcomp.robot.machine import Machine


@dataclass(frozen=True)
class Efforts:
    """k records of n axes. q, velocity: m or rad, and per second; measured: effort of the motor by its measured
    current; forward: what the core held to be needed; error: counts from the target of a hold, else NaN.
    """

    q: np.ndarray
    velocity: np.ndarray
    measured: np.ndarray
    forward: np.ndarray
    error: np.ndarray
    is_hold: np.ndarray

    @property
    def servo(self) -> np.ndarray:
        """What the feed-forward did not know (k, n)."""
        return self.measured - self.forward


def efforts(entries: list[Entry], steps: list[Step], machine: Machine) -> Efforts:
    """Of entries of a route."""
    records, velocity = joined(entries, machine.n_axes)
    own = [steps[entry.step] for entry in entries for _ in entry.words]
    is_hold = np.array([step.kind == HOLD for step in own])
    poses = np.where(is_hold[:, None], [step.pose for step in own], np.nan)
    return Efforts(
        q=machine.drive.positions(records.count),
        velocity=velocity,
        measured=records.sense * 1e-6 * machine.drive.effort_per_ampere,
        forward=records.force * 1e-3,
        error=poses - records.count,
        is_hold=is_hold,
    )


def noise(entries: list[Entry], machine: Machine) -> float:
    """RMS of what is not the same in the records of one approach of a hold, N or N m, over all axes."""
    spreads = []
    for entry in entries:
        if len(entry.words) == 2 * RECORDS_OF_HOLD:
            records, _ = joined([entry], machine.n_axes)
            sense = records.sense.reshape(2, RECORDS_OF_HOLD, -1) * 1e-6 * machine.drive.effort_per_ampere
            spreads.append(np.var(sense, axis=1, ddof=1))
    return float(np.sqrt(np.mean(spreads))) if spreads else 0.0


def figures(e: Efforts) -> dict:
    """Servo's effort over all records, at rest and in motion, as errors in a report; tracking error of the holds."""
    rows = {"all": np.ones(len(e.q), bool), "holds": e.is_hold, "motion": ~e.is_hold}
    servo = {name: errors(e.servo[own], e.measured[own]) for name, own in rows.items() if own.any()}
    at_rest = e.error[e.is_hold]
    tracking = {"rms_counts": float(np.sqrt(np.mean(at_rest**2))), "max_counts": float(np.abs(at_rest).max())}
    return {"servo": servo, "tracking": tracking}
