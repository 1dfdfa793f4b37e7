"""A certificate as text: what is proven, what was found, where."""

import math

import numpy as np

from gravcomp.certify.certificate import Certificate, Certifier
from gravcomp.certify.search import N_POSES

_SOUGHT = 0.5


def lines(certifier: Certifier, certificate: Certificate, seed: int) -> list[str]:
    """Markdown: the bound of each unit, a row per axis, how it was come by."""
    proven, searched = certificate.bounded, f"{N_POSES} poses, seed {seed}, climbing from the worst"
    largest = certifier.of_unit(proven.bound)
    whole = ", ".join(
        f"{upward(value)} {unit}" for unit, value in dict(zip(certificate.units, largest, strict=True)).items()
    )
    text = [
        f"{certifier.machine.name}: at every pose of the workspace, proven, |force of gc_core - statics| <= {whole}",
        "",
        *_table(certifier, certificate),
        "",
        f"{proven.n_boxes} boxes, {certificate.seconds:.0f} s; largest found: {searched}, and the middles of the boxes",
    ]
    if not certificate.is_complete:
        text.append(f"the time was up: boxes were left to split; the worst is {_box(certifier, certificate)}")
    return text


def _table(certifier: Certifier, certificate: Certificate) -> list[str]:
    """Parameters are told beside positions where they are others."""
    found, proven, formula = certificate.found, certificate.bounded.bound, certifier.formula
    q = formula.at(found.parameters)[0]
    names = () if np.array_equal(q, found.parameters) else formula.names
    header = ["axis", "proven", "largest found", "proven of found, %", "found at q", *names]
    rows = []
    for k, unit in enumerate(certificate.units):
        # An axis far below the others of its unit was not what boxes were split for.
        is_sought = found.size[k] > _SOUGHT * certifier.of_unit(found.size)[k]
        share = f"{100.0 * proven[k] / found.size[k]:.1f}" if is_sought else ""
        cells = [k + 1, f"{upward(proven[k])} {unit}", f"{found.size[k]:.5f} {unit}", share, _vector(q[k])]
        rows.append([*cells, *(f"{value:.5f}" for _, value in zip(names, found.parameters[k], strict=False))])
    return ["| " + " | ".join(map(str, row)) + " |" for row in (header, ["---"] * len(header), *rows)]


def upward(value: float) -> str:
    """Five decimals, never below the value."""
    rounded = f"{value:.5f}"
    return rounded if float(rounded) >= value or not math.isfinite(value) else f"{value + 1e-5:.5f}"


def _box(certifier: Certifier, certificate: Certificate) -> str:
    box = certificate.bounded.open
    sides = zip(certifier.formula.names, box.low[:, 0], box.high[:, 0], strict=True)
    return ", ".join(f"{name} {low:.6f} .. {high:.6f}" for name, low, high in sides)


def _vector(q: np.ndarray) -> str:
    return ", ".join(f"{value:.5f}" for value in q)
