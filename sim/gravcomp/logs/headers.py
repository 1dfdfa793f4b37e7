"""Names of columns as people write them: ``q1_deg``, ``q1 [deg]``, ``Position 1 (mm)``, ``q1`` above a row of units."""

import re
from dataclasses import dataclass

from gravcomp.errors import InputError
from gravcomp.logs.units import unit_of_symbol

_WORDS = {
    "t": "t", "time": "t", "timestamp": "t", "temp": "temp", "temperature": "temp",
    "q": "q", "pos": "q", "position": "q", "angle": "q", "v": "v", "vel": "v", "velocity": "v", "speed": "v",
    "f": "f", "force": "f", "tau": "f", "torque": "f", "effort": "f", "i": "i", "cur": "i", "current": "i",
    "fm": "fm", "model": "fm", "gravity": "fm",
}  # fmt: skip
_BARE = re.compile(r"([a-z]+)[ _.-]*([1-9]\d*)?", re.IGNORECASE)
_WITH_UNIT = re.compile(r"(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\)|\s/\s*(\S+)|\sin\s(\S+))")
_PLAIN = re.compile(r"(?:(t|temp)|(q|v|f|i|fm)([1-9]\d*))_[a-z]+", re.IGNORECASE)


@dataclass(frozen=True)
class Column:
    """original: as the file has it; name: kind, axis and unit, as ``q1_deg``, or the original; kind "" if none known;
    should_be: kind and axis of a name that lacks its unit, and so is none.
    """

    original: str
    name: str
    kind: str
    should_be: str = ""


def column(original: str, unit: str = "", where: str = "") -> Column:
    """The column of a header's name, with what a row of units says. Raises InputError where the unit is none."""
    plain = _PLAIN.fullmatch(original)
    if plain:
        own = unit_of_symbol(unit) if unit else None
        if own and own != original.rpartition("_")[2]:
            raise InputError(f"{where}: column {original}: the row of units says {unit}; keep one of the two")
        return Column(original, original, (plain[1] or plain[2]).lower())
    split = _WITH_UNIT.fullmatch(original)
    stem, symbol = (split[1], next(x for x in split.groups()[1:] if x is not None)) if split else (original, unit)
    bare = _BARE.fullmatch(stem.strip())
    kind = _WORDS.get(bare[1].lower(), "") if bare else ""
    if not kind or (kind in ("t", "temp")) == bool(bare[2]):
        return Column(original, original, "")
    name = kind + (bare[2] or "")
    known = unit_of_symbol(symbol)
    if symbol and known is None and where:
        raise InputError(f"{where}: column {original}: {symbol!r} is no known unit; convert it to one that is, "
                         "such as deg, mm, Nm, mA")  # fmt: skip
    return Column(original, f"{name}_{known}", kind) if known else Column(original, original, kind, name)


def is_unit_row(names: list[str], cells: list[str]) -> bool:
    """Do the cells below the names tell units? All that are not empty do, below known names at least one."""
    told = [(name, cell) for name, cell in zip(names, cells, strict=True) if cell and column(name).kind]
    return bool(told) and all(unit_of_symbol(cell) for _, cell in told)
