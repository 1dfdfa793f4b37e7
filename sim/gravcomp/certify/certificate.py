"""The largest error of the core over all poses of the workspace: a number that is proven, not sampled.

|force of gc_core - statics of the robot| <= X, at every pose: that of the bit-true model of the VHDL, its encoders
rounding to the nearest count; the statics in real arithmetic, their constants as double precision holds them.
"""

import time
from dataclasses import dataclass, replace

import numpy as np

from gravcomp.certify.branch import Bounded, Boxes, branch_and_bound
from gravcomp.certify.core import core_forces
from gravcomp.certify.search import N_POSES, WorstPose
from gravcomp.certify.taylor import Taylor, pairs
from gravcomp.core.formats import FixedNetwork
from gravcomp.errors import InputError
from gravcomp.network.inputs import SIN_COS
from gravcomp.robot.machine import EFFORT_UNITS, Machine
from gravcomp.robot.protocol import Formula, HasFormula
from gravcomp.twin import network as bittrue

_N_WORST = 16


@dataclass(frozen=True)
class Certificate:
    """What is proven of every axis, and the largest errors found."""

    bounded: Bounded
    found: WorstPose
    units: list[str]
    seconds: float

    @property
    def is_complete(self) -> bool:
        """Whether all was proven that was to be; otherwise the time was up."""
        return self.bounded.open is None


class Certifier:
    """Errors of one machine's core, at poses and over boxes of the parameters of its formula.

    Raises InputError where the robot's statics are no formula.
    """

    def __init__(self, machine: Machine, fixed: FixedNetwork):
        if fixed.is_lean:
            raise InputError(
                f"{machine.where}: [network] form = {fixed.form!r}: the paper's form alone is followed; "
                "give form = 'paper'"
            )
        if not isinstance(machine.robot, HasFormula):
            raise InputError(
                f"{machine.where}: [model] kind = {machine.table['model']['kind']!r}: efforts are known at single "
                "poses alone, nothing can be proven of the others; give a robot with a formula, spheiro or mujoco"
            )
        try:
            self.formula = _one_turn(machine.robot.formula(), fixed)
        except InputError as error:
            raise InputError(f"{machine.where}: nothing can be proven of this robot: {error}") from error
        self.machine, self.fixed = machine, fixed
        self.units = [EFFORT_UNITS[unit] for unit in machine.position_units]
        self.found = WorstPose(self.errors, self.formula.low, self.formula.high)
        self.least = np.zeros(machine.n_axes)

    def errors(self, parameters: np.ndarray) -> np.ndarray:
        """Core less statics (N, n), N or Nm, at parameters (N, k), bit for bit."""
        q, effort = self.formula.at(parameters)
        return 1e-3 * bittrue.core(self.machine.drive.counts(q), self.fixed).force_mn - effort

    def boxes(self, low: np.ndarray, high: np.ndarray) -> Boxes:
        """Boxes low to high (k, N) with the bounds of their errors; their middles are looked at too.

        What can be proven of single poses, the middles of the worst boxes, raises the least that can be of them all.
        """
        middle = (low + high) / 2
        self.found.look_at(middle.T)
        bound, spread = self.bound(low, high)
        worst = middle[:, np.argsort(-bound.max(axis=0))[:_N_WORST]]
        self.least = np.maximum(self.least, self.bound(worst, worst)[0].max(axis=1))
        return Boxes(low, high, bound, spread.argmax(axis=0))

    def bound(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bound (n, N) of the sizes of errors in boxes, infinite where arithmetic has none; spread as ``enclosed``."""
        least, most, spread = self.enclosed(low, high)
        bound = np.maximum(np.abs(least), np.abs(most))
        return np.where(np.isnan(bound), np.inf, bound), spread

    def enclosed(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Lowest and highest error (n, N) in boxes low to high (k, N), and how much of the width each variable (k, N)
        is to blame for."""
        parameters = np.array(Taylor.variables(low, high), dtype=object)[None]
        with np.errstate(all="ignore"):  # what is not bounded ends as no number
            q, effort = self.formula.at(parameters)
            core = core_forces(list(q[0]), self.fixed, self.machine.drive)
            errors = [force - holding for force, holding in zip(core.forces, effort[0], strict=True)]
            least, most = np.array([error.bounds() for error in errors]).swapaxes(0, 1)
            spread = core.spread + sum(_spread(one) for one in effort[0] if isinstance(one, Taylor))
        # Wide boxes have no numbers to go by: their longest side is halved.
        share = (high - low) / np.maximum(self.formula.high - self.formula.low, 1e-300)[:, None]
        return least, most, np.where(np.isfinite(spread).all(axis=0), spread, share)

    def of_unit(self, values: np.ndarray) -> np.ndarray:
        """The largest of the values (n,) of all axes of the same unit as each."""
        return np.array([max(v for v, u in zip(values, self.units, strict=True) if u == unit) for unit in self.units])


def _one_turn(formula: Formula, fixed: FixedNetwork) -> Formula:
    """Axes whose sine and cosine the network sees: every turn is like the first, statics and bounds of the core."""
    is_turning = np.array([kind == SIN_COS for kind in fixed.inputs])
    if not is_turning.any():
        return formula
    turn = formula.low + 2.0 * np.pi * (1.0 + 1e-12)
    return replace(formula, high=np.where(is_turning, np.minimum(formula.high, turn), formula.high))


def _spread(model: Taylor) -> np.ndarray:
    """The radius, shared out to the variables (k, N) as their parts in the terms of degree 2 are."""
    i, j = pairs(model.n)
    size = np.abs(model.quadratic)
    part = np.stack([size[(i == k) | (j == k)].sum(axis=0) for k in range(model.n)])
    return model.radius * part / np.maximum(part.sum(axis=0), 1e-300)


def certify(certifier: Certifier, gap: float, claim: float | None, seconds: float, seed: int) -> Certificate:
    """Prove a bound of every axis: the claim, or no more than (1 + gap) times what is proven of the worst pose alone,
    of all axes of its unit.

    After seconds, what is proven by then is returned. Raises InputError for a claim that a pose breaks, or that this
    arithmetic cannot prove of a single one.
    """
    began, found = time.monotonic(), certifier.found
    found.search(N_POSES, seed)

    def wanted() -> np.ndarray:
        if claim is None:
            return (1.0 + gap) * certifier.of_unit(certifier.least)
        if found.size.max() > claim:
            raise InputError(_broken(certifier, claim))
        if certifier.least.max() > claim:
            raise InputError(
                f"{claim:g} is not proven, nor broken: with every dropped bit at its worst no less than "
                f"{certifier.least.max():.4f} can be proven of a single pose; claim more"
            )
        return np.full_like(found.size, claim)

    wanted()
    bounded = branch_and_bound(certifier.boxes, wanted, certifier.formula.low, certifier.formula.high, seconds)
    return Certificate(bounded, found, certifier.units, time.monotonic() - began)


def _broken(certifier: Certifier, claim: float) -> str:
    """The pose that breaks a claim, and a box around it of which every pose does."""
    found, names = certifier.found, certifier.formula.names
    axis = int(found.size.argmax())
    at, unit = found.parameters[axis], certifier.units[axis]
    q = ", ".join(f"{value:.6f}" for value in certifier.formula.at(at[None])[0][0].astype(float))
    text = f"{claim:g} {unit} is broken at q = ({q}): axis {axis + 1} is {found.size[axis]:.6f} {unit} off"
    box = _box_beyond(certifier, axis, claim)
    if box is not None:
        sides = ", ".join(f"{name} {low:.6f} .. {high:.6f}" for name, low, high in zip(names, *box, strict=True))
        text += f", and above the claim at every pose of {sides}"
    return f"{text}; claim more, or train again"


def _box_beyond(certifier: Certifier, axis: int, claim: float) -> tuple[np.ndarray, np.ndarray] | None:
    """The largest of some boxes around the worst pose found in which every error is above the claim; None: no box."""
    at, (low, high) = certifier.found.parameters[axis], (certifier.formula.low, certifier.formula.high)
    sides = (high - low) * 0.5 ** np.arange(4, 24)[:, None]  # largest first
    lows, highs = np.maximum(at - sides, low), np.minimum(at + sides, high)
    least, most, _ = certifier.enclosed(lows.T, highs.T)
    beyond = np.flatnonzero((least[axis] > claim) | (most[axis] < -claim))
    return (lows[beyond[0]], highs[beyond[0]]) if beyond.size else None
