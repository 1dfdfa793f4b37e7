"""Values of robot.toml, checked: each function raises InputError naming place and key."""

from collections.abc import Iterable, Mapping
from fractions import Fraction

from gravcomp.errors import InputError

_LARGEST = 10**15  # of a ratio: more than a counter takes, and a float holds it exactly


def entry(table: Mapping, where: str, key: str):
    """The value of a key that must be there."""
    if not isinstance(table, Mapping) or key not in table:
        raise InputError(f"{where}: {key} is missing; add it")
    return table[key]


def only(table: Mapping, where: str, known: Iterable[str]) -> None:
    """Raise InputError for a key that means nothing: misspelt, it would be left out in silence."""
    for key in table:
        if key not in known:
            raise InputError(f"{where}: {key} is not known; give {', '.join(sorted(known))}")


def finite(table: Mapping, where: str, key: str) -> float:
    value = entry(table, where, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e300:
        raise InputError(f"{where}: {key} = {value!r} is not a finite number; give one")
    return float(value)


def positive(table: Mapping, where: str, key: str) -> float:
    value = finite(table, where, key)
    if value <= 0:
        raise InputError(f"{where}: {key} = {value!r} is out of range; give a positive number")
    return value


def text(table: Mapping, where: str, key: str) -> str:
    value = entry(table, where, key)
    if not isinstance(value, str) or not value:
        raise InputError(f"{where}: {key} = {value!r} is not a text; give one")
    return value


def ratio(value, where: str) -> float:
    """A whole number or "a/b": the phase of a joint that turns for ever must not drift."""
    try:
        if isinstance(value, bool) or not isinstance(value, (int, str)):
            raise ValueError
        number = Fraction(value)
    except (ValueError, ZeroDivisionError):
        raise InputError(f'{where} = {value!r} is not a whole number or a ratio "a/b"; give one') from None
    if not 1 / Fraction(_LARGEST) <= number <= _LARGEST:
        shown = repr(value) if len(repr(value)) < 40 else f"{repr(value)[:36]}..."
        raise InputError(f"{where} = {shown} is out of range; give a positive number up to {_LARGEST:.0e}")
    return float(number)
