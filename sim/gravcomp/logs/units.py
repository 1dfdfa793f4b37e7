"""Units that people's headers have, and what they are in those of the measured CSV."""

import math
from collections.abc import Mapping

from gravcomp.errors import InputError

# unit in a header: (unit of the contract, its factor)
KNOWN = {
    "deg": ("rad", math.pi / 180.0), "mrad": ("rad", 1e-3), "rev": ("rad", 2.0 * math.pi),
    "mm": ("m", 1e-3), "cm": ("m", 1e-2), "um": ("m", 1e-6),
    "degps": ("radps", math.pi / 180.0), "mradps": ("radps", 1e-3), "rpm": ("radps", 2.0 * math.pi / 60.0),
    "mmps": ("mps", 1e-3), "cmps": ("mps", 1e-2), "umps": ("mps", 1e-6),
    "kn": ("n", 1e3), "mn": ("n", 1e-3), "ncm": ("nm", 1e-2), "nmm": ("nm", 1e-3), "mnm": ("nm", 1e-3),
    "knm": ("nm", 1e3), "ma": ("a", 1e-3),
    "ms": ("s", 1e-3), "us": ("s", 1e-6), "ns": ("s", 1e-9),
}  # fmt: skip
# Units of a drive or an encoder: only their user knows the factor.
OF_THE_MACHINE = ("permille", "percent", "pct", "counts", "lsb", "raw")
CONTRACT = ("m", "rad", "mps", "radps", "n", "nm", "a", "s")


def parse_units(pairs: list[str]) -> dict[str, tuple[str, float]]:
    """``counts=1e-6m`` of a command line as {"counts": ("m", 1e-6)}. Raises InputError."""
    out = {}
    for pair in pairs:
        name, _, size = pair.partition("=")
        unit = next((u for u in sorted(CONTRACT, key=len, reverse=True) if size.lower().endswith(u)), "")
        try:
            factor = float(size[: -len(unit)] if unit else "")
        except ValueError:
            factor = math.nan
        if name not in OF_THE_MACHINE or not math.isfinite(factor) or factor == 0.0:
            names, units = ", ".join(OF_THE_MACHINE), ", ".join(CONTRACT)
            raise InputError(
                f"--units {pair}: not NAME=FACTOR and unit; give {names} in one of {units}, permille=0.05n"
            )
        out[name] = (unit, factor)
    return out


def in_contract(name: str, given: Mapping[str, tuple[str, float]]) -> tuple[str, float] | None:
    """The column's name in the contract's unit and the factor to it; None where its unit is no known one."""
    stem, _, unit = name.rpartition("_")
    found = {**KNOWN, **given}.get(unit)
    return (f"{stem}_{found[0]}", found[1]) if found else None
