"""How much of the held-out residual goes with which entry of the fit, per axis, so that all parts add up to one.

    r = sum over entries of F_e + what is left,   part_e = <F_e, r> / <r, r>

(Pratt, 1987). Of terms that overlap each has what it brings beside the others; a negative part is a term that takes
back what another gives too much. ``Diagnosis.shares`` is another question: what no other entry can take over.
"""

from dataclasses import dataclass

import numpy as np

from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.shares import along
from gravcomp.diagnosis.thresholds import TINY

LEFT = "left"  # kind of what no entry explains


@dataclass(frozen=True)
class Contribution:
    """kind: effect, correction or left; by_axis (k,): parts of each axis' square sum; whole: of that of all axes."""

    name: str
    kind: str
    by_axis: np.ndarray
    whole: float


def contributions(d: Diagnosis) -> list[Contribution]:
    """Effects, corrections, what is left: the largest of each kind first."""
    use = counted(d)
    r = np.where(use, d.before, 0.0)
    energy = np.maximum((r**2).sum(axis=0), TINY)
    found, left = {}, np.where(use, d.after, 0.0)
    explained = r - left
    for kind, entries in (("effect", d.fit.effects), ("correction", d.fit.corrections)):
        for entry in entries:
            found[entry.name, kind] = found.get((entry.name, kind), 0.0) + along(d.data, entry, use, d.before)
            explained = explained - np.where(use, d.data.once(entry.force), 0.0)
    of_sensors = [entry.name for entry in d.fit.effects if not d.data.once(entry.force).any()]
    for name in of_sensors:  # their log is corrected before anything is fitted; together they are what no force is
        found[name, "effect"] = (explained * r).sum(axis=0) / len(of_sensors)
    out = [
        Contribution(name, kind, own / energy, float(own.sum() / energy.sum())) for (name, kind), own in found.items()
    ]
    out.sort(key=lambda own: (own.kind != "effect", -own.whole))
    rest = (left * r).sum(axis=0)
    return [*out, Contribution("nothing", LEFT, rest / energy, float(rest.sum() / energy.sum()))]


def counted(d: Diagnosis) -> np.ndarray:
    """Held-out samples without gross errors, (n, k)."""
    return d.is_test[:, None] & ~d.left_out
