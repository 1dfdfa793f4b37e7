"""What one wrong bit did, judged.

harmless        the command of every axis stays within 1 % of that without the fault, and no state differs at the end
braked          a cause is latched, brakes are engaged and the command is zero
latent          the command of every axis stays within LATENT_MN of that without the fault; a state differs for good
silently wrong  everything else: a command that is wrong and then right again; a brake or enable pin that differs for a
                single clock without a cause latched; brakes that engage without a cause; a brake that is released
                while that without the fault is engaged, whatever comes after

A command that comes up to a tick sooner or later is not wrong: what it is compared with is the range of the right one
over that time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from scipy.stats import binomtest

HARMLESS, BRAKED, LATENT, SILENT = CLASSES = ("harmless", "braked", "latent", "silently wrong")
# About the error that the network itself has against the statics, RMS.
LATENT_MN = 60.0


@dataclass(frozen=True)
class Outcome:
    """A run with one flip, compared with that without.

    clocks: until no state differed any more (converged), or of the whole run. reaches: another instance or a pin was
    changed. largest_ua: per axis, of the difference of the command; wrong_clocks with one above 1 %, the first of them
    at first_wrong, -1 for none. brake_clocks: longest time that brake or enable pins differ. released_wrongly: a brake
    that should be engaged was not. brakes, enable: pins at the end. causes: latched at the end. left: stores that
    differ at the end, by number, the first few.
    """

    converged: bool
    clocks: int
    reaches: bool
    largest_ua: tuple[int, ...]
    wrong_clocks: int
    first_wrong: int
    brake_clocks: int
    released_wrongly: bool
    brakes: int
    enable: int
    causes: int
    left: tuple[int, ...]


def parse(line: str, n_axes: int = 3) -> Outcome:
    """The Outcome in an answer of the bench."""
    n = [int(word) for word in line.split()]
    ends, rest = 3 + n_axes, n[3 + n_axes :]
    return Outcome(bool(n[0]), n[1], bool(n[2]), tuple(n[3:ends]), rest[0], rest[1], rest[2], bool(rest[3]), rest[4],
                   rest[5], rest[6], tuple(rest[7:]))  # fmt: skip


def classify(o: Outcome, ua_per_mn: float) -> str:
    """One of CLASSES."""
    if o.released_wrongly:
        return SILENT
    if o.causes and not o.brakes and not o.enable:
        return BRAKED
    if o.wrong_clocks or o.brake_clocks:
        return SILENT
    if o.converged:
        return HARMLESS
    return LATENT if max(o.largest_ua) <= LATENT_MN * ua_per_mn else SILENT


def upper_bound(n_found: int, n: int) -> float:
    """Upper end of the 95 % interval (Clopper-Pearson) of the share of which n_found were seen in n."""
    return float(binomtest(n_found, n).proportion_ci(0.95, method="exact").high)


def counts(classes: Sequence[str]) -> dict[str, int]:
    """How often each class occurs."""
    return {name: sum(found == name for found in classes) for name in CLASSES}
