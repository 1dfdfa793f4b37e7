"""Two logs of one machine as one, in the order in which they were taken."""

from dataclasses import replace

import numpy as np

from gravcomp.errors import InputError
from gravcomp.logs.clock import usual_step
from gravcomp.logs.force_surface import fit_force_function
from gravcomp.logs.measurement import Measurement


def joined(first: Measurement, then: Measurement) -> Measurement:
    """The rows of both, runs kept apart; the second begins one usual step after the end of the first.

    Raises InputError where they have other axes, units or columns.
    """
    same = [(log.position_units, log.effort_units, log.has_velocity, log.temp_c is None) for log in (first, then)]
    if same[0] != same[1]:
        raise InputError(f"{then.name}: other axes, units or columns than {first.name}; log both alike")
    rows, step = stacked(first, then), usual_step(first.t_s, first.runs)
    of_both = first.force_at
    if first.robot is None or first.is_predicted:
        of_both = fit_force_function(rows.q, rows.nominal, list(first.position_units))
        of_both = of_both or (first.robot.forces if first.robot is not None else None)
    t_s = np.concatenate([first.t_s, then.t_s - then.t_s[0] + first.t_s[-1] + step])
    return replace(
        rows, t_s=t_s, force_at=of_both, run=np.concatenate([first.runs, then.runs + first.runs.max() + 1]),
        notes=(*first.notes, *then.notes), n_dropped=first.n_dropped + then.n_dropped,
    )  # fmt: skip


def stacked(first: Measurement, then: Measurement) -> Measurement:
    """The rows of both, with the times and runs that they have."""

    def both(name: str):
        a, b = getattr(first, name), getattr(then, name)
        return None if a is None or b is None else np.concatenate([a, b])

    unsure = [np.zeros(log.shape, bool) if log.unsure is None else log.unsure for log in (first, then)]
    arrays = {name: both(name) for name in ("t_s", "q", "v", "force", "nominal", "temp_c")}
    return replace(first, **arrays, run=np.concatenate([first.runs, then.runs]),
                   unsure=np.concatenate(unsure) if any(own.any() for own in unsure) else None)  # fmt: skip
