"""Units that people's headers have, and what they are in those of the measured CSV."""

import math
import re
from collections.abc import Mapping

from gravcomp.errors import InputError

# unit in a header: (unit of the contract, its factor)
KNOWN = {
    "deg": ("rad", math.pi / 180.0), "mrad": ("rad", 1e-3), "rev": ("rad", 2.0 * math.pi),
    "mm": ("m", 1e-3), "cm": ("m", 1e-2), "um": ("m", 1e-6), "inch": ("m", 0.0254),
    "degps": ("radps", math.pi / 180.0), "mradps": ("radps", 1e-3), "rpm": ("radps", 2.0 * math.pi / 60.0),
    "revps": ("radps", 2.0 * math.pi),
    "mmps": ("mps", 1e-3), "cmps": ("mps", 1e-2), "umps": ("mps", 1e-6), "mmpmin": ("mps", 1e-3 / 60.0),
    "mpmin": ("mps", 1.0 / 60.0),
    "kn": ("n", 1e3), "mn": ("n", 1e-3), "lbf": ("n", 4.4482216152605),
    "ncm": ("nm", 1e-2), "nmm": ("nm", 1e-3), "mnm": ("nm", 1e-3), "knm": ("nm", 1e3), "ozin": ("nm", 7.0615518e-3),
    "lbfin": ("nm", 0.1129848290276), "ma": ("a", 1e-3),
    "ms": ("s", 1e-3), "us": ("s", 1e-6), "ns": ("s", 1e-9), "min": ("s", 60.0),
}  # fmt: skip
# Units of a drive or an encoder: only their user knows the factor.
OF_THE_MACHINE = ("permille", "percent", "pct", "counts", "lsb", "raw")
CONTRACT = ("m", "rad", "mps", "radps", "n", "nm", "a", "s")
_FREE = {*KNOWN, *CONTRACT, *OF_THE_MACHINE, "c"}
# Spellings between brackets or in a row of units that lower case, "ps" for "/s" and no signs of multiplication miss.
_SPELLINGS = {
    "°": "deg", "degree": "deg", "degrees": "deg", "°ps": "degps", "dps": "degps", "°c": "c", "degc": "c",
    "1pmin": "rpm", "upmin": "rpm", "rpmin": "rpm", "revpmin": "rpm", "min-1": "rpm", "min^-1": "rpm", "1/min": "rpm",
    "turn": "rev", "turns": "rev", "rps": "revps", "radps": "radps", "sec": "s", "seconds": "s", "msec": "ms",
    "in": "inch", "ozfin": "ozin", "lbin": "lbfin", "inlb": "lbfin", "inoz": "ozin",
    "%": "percent", "‰": "permille", "count": "counts", "inc": "counts", "incr": "counts", "increments": "counts",
}  # fmt: skip
_NAME = re.compile(rf"({'|'.join(OF_THE_MACHINE)}|a)([1-9]\d*)?")


def unit_of_symbol(symbol: str) -> str | None:
    """The name of a unit as people write it, "mm/s", "N·m", "°", "1/min"; None where it is none that is known.

    A capital M before N or A is mega, which no axis has: MNm is not mNm.
    """
    text = symbol.strip().strip("[]() ")
    if re.match("M[NA]", text):
        return None
    text = re.sub(r"[\s·⋅*._-]", "", text.lower().replace("μ", "u").replace("µ", "u"))
    text = re.sub(r"/(s|sec|second)$", "ps", re.sub(r"/min$", "pmin", text))
    text = re.sub(r"s-1$|s\^1$", "ps", text)
    found = _SPELLINGS.get(text, text)
    return found if found in _FREE else None


def parse_units(pairs: list[str]) -> dict[str, tuple[str, float]]:
    """``counts=1e-6m`` of a command line as {"counts": ("m", 1e-6)}; ``a2=0.1nm`` is the ampere of axis 2.

    Raises InputError.
    """
    out = {}
    for pair in pairs:
        name, _, size = pair.partition("=")
        unit = next((u for u in sorted(CONTRACT, key=len, reverse=True) if size.lower().endswith(u)), "")
        try:
            factor = float(size[: -len(unit)] if unit else "")
        except ValueError:
            factor = math.nan
        is_ampere = name.startswith("a") and unit not in ("n", "nm")
        if not _NAME.fullmatch(name) or is_ampere or not math.isfinite(factor) or factor == 0.0:
            names, units = ", ".join(OF_THE_MACHINE), ", ".join(CONTRACT)
            raise InputError(f"--units {pair}: not NAME=FACTOR and unit; give {names} in one of {units}, "
                             "permille=0.05n; or a, the ampere, in n or nm; of axis 2 alone a2=0.1nm")  # fmt: skip
        out[name] = (unit, factor)
    return out


def in_contract(name: str, given: Mapping[str, tuple[str, float]]) -> tuple[str, float] | None:
    """The column's name in the contract's unit and the factor to it; None where its unit is no known one.

    A size that was given holds for all axes, one with a number for that axis. A current of known size is a force.
    """
    stem, _, unit = name.rpartition("_")
    axis = re.search(r"\d*$", stem)[0]
    found = {**KNOWN, **given}.get(unit)
    found = given.get(f"{unit}{axis}", found) if axis else found
    if found is None:
        return None
    if found[0] in ("n", "nm") and stem == f"i{axis}":
        stem = f"f{axis}"
    return f"{stem}_{found[0]}", found[1]
