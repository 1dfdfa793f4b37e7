"""What every effect is: a candidate with a name, an equation and a place in hardware.

An effect is added to the model: f_exp = f_model(q) + sum of effects.
"""

from collections.abc import Mapping

import numpy as np

from gravcomp.diagnosis.candidate import Candidate, Parameter, Variable
from gravcomp.diagnosis.thresholds import COMPLEXITY, PHYSICAL_PRICE, SCAN_PRICE
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.mechanics import Mechanics
from gravcomp.robot.protocol import Robot


class Effect(Candidate):
    """Base class. Parameters end in the axis they belong to (``b_1``) where the effect acts axis by axis."""

    name = ""
    equation = ""
    driver = ""  # kind of the measured variable it is a function of: q, v, dir, f, a (each axis its own)
    hardware = "none"  # "network": retrained statics; "compensator": friction or position table; "none"
    units: dict[str, str] = {}  # noqa: RUF012 - parameter stem -> unit, with [q] and [f] for position and effort
    per_axis = True
    shared: tuple[str, ...] = ()  # stems of parameters that all axes have in common
    positive: tuple[str, ...] = ()  # stems of labels whose coefficients can only be >= 0
    sensor = ""  # what is to be checked, where a sensor is wrong and not the machine
    remedy = ""  # what tells it from a rival where no motion or hold does
    complexity = (
        "everywhere"  # how usual it is, a level of COMPLEXITY: of two equal explanations the usual one is named
    )

    @property
    def is_by_axis(self) -> bool:
        return self.per_axis and not self.shared

    @property
    def is_of_own_position(self) -> bool:
        return self.per_axis and self.driver == "q"

    @property
    def price(self) -> float:
        return PHYSICAL_PRICE + COMPLEXITY[self.complexity] + (SCAN_PRICE if self.is_scanned else 0.0)

    def has(self, parameter: Parameter) -> bool:
        """Is this the name of one of its parameters? Stems of ``units``, perhaps with a unit or a part behind."""
        own = next((stem for stem in self.units if parameter.stem == stem), None)
        if own is None:
            return (not self.per_axis and any(parameter.stem.startswith(f"{stem}_") for stem in self.units)) or any(
                parameter.axis is None and parameter.stem == f"{stem}_s" for stem in self.units
            )
        return parameter.axis is not None or own in self.shared

    def unavailable(self, data: Measurement) -> str:
        """Why this data cannot show the effect; empty when it can."""
        return ""

    def shapes(self, data: Measurement) -> list[dict]:
        """Shape parameters that the search tries."""
        return [{}]

    def scanned_shapes(self, data: Measurement, rows: np.ndarray, residual: np.ndarray) -> set[tuple]:
        """Shapes, as items, that a scan of a residual (rows, k) proposes."""
        return set()

    def seen_in(self, data: Measurement) -> dict[Parameter, tuple[float, float]]:
        """Of an effect of a sensor: its parameters and half their 95 % intervals, where the log shows it before
        anything is fitted.
        """
        return {}

    is_certain = True  # of an effect of a sensor: no effect of the machine could show the same

    def corrected(self, data: Measurement, parameters: Mapping[str, float]) -> Measurement:
        """Of an effect of a sensor: the log as a right sensor would have written it."""
        return data

    def same_as(self, parameters: Mapping[str, float]) -> tuple[str, ...]:
        """Names of effects that give the same force on any data, with other parameters."""
        return ()

    def doubt(self, data: Measurement, parameters: Mapping[str, float]) -> np.ndarray:
        """How much of the force (n, k) has a direction that the log does not tell, beside that of the axes."""
        return np.zeros(data.shape)

    def unseen(self, data: Measurement, parameters: Mapping[str, float], is_test: np.ndarray) -> np.ndarray:
        """Held-out samples (n, k) at which no training can tell the force: it changes somewhere among them."""
        return np.zeros(data.shape, bool)

    def mechanics(self, robot: Robot, parameters: Mapping[str, float]) -> Mechanics | None:
        """What the file of the robot takes of it; None where such a file has no place for it."""
        return None

    def constants(self, data: Measurement, parameters: Mapping[str, float]) -> dict[str, np.ndarray]:
        """What the compensator takes of an effect in hardware: constants by name of the field of Compensation."""
        return {}

    def groups(self, labels):
        if not self.per_axis:
            return []
        axes = sorted({label.axis for label in labels})
        return [{label for label in labels if label.axis == axis} for axis in axes]

    def allowance(self, label, known):
        """A coefficient may be this far below zero: the model has so much already, in both directions or in one."""
        both = Parameter(label.stem.removesuffix("_pos").removesuffix("_neg"), label.axis)
        return max(sum(own.get(name, 0.0) for own in known.values() for name in {label, both}), 0.0)

    def contrasts(self, labels):
        return [{label: 1.0} for label in labels if label.stem in self.positive]

    def follows(self, data, parameters, force):
        if not self.driver:
            return []
        return [(int(axis), Variable(self.driver, int(axis))) for axis in np.flatnonzero(force.any(axis=0))]

    def is_directional(self, labels: tuple[Parameter, ...]) -> bool:
        return any(label.stem.endswith("_pos") for label in labels)


def held_out_about(data: Measurement, t_s: float, is_test: np.ndarray) -> np.ndarray:
    """The held-out rows (n,) between the last row of the training before a moment and the first after it."""
    seen = data.t_s[~is_test]
    before, after = seen[seen <= t_s].max(initial=-np.inf), seen[seen > t_s].min(initial=np.inf)
    return is_test & (data.t_s > before) & (data.t_s < after)


def needs_velocity(data: Measurement) -> str:
    return "" if data.has_velocity else "no velocity; log that of the motion, or of the approach to a hold"


def needs_time(data: Measurement) -> str:
    axis = data.axis_as_time
    return "" if axis is None else (f"time cannot be told from q{axis + 1}, whose places were visited one after the "
                                    "other; take the poses in random order")  # fmt: skip


def needs_function(data: Measurement) -> str:
    return "" if data.force_at is not None else "the model is known at the samples only, not as a function of position"
