"""What a threshold of the diagnosis decides: blind sets diagnosed with it halved, with it doubled, and as it is."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from gravcomp.diagnosis import thresholds
from gravcomp.logs import thresholds as of_logs
from gravcomp_lab.blind.tally import OpenedSet, run_model_case

FACTORS = (0.5, 2.0)
TABLE = {name: value for module in (of_logs, thresholds) for name, value in vars(module).items() if name.isupper()}
_COUNTS = {  # what a tally counts, of sets with an answer
    "right": lambda o: o.is_right,
    "wrong name": lambda o: o.has_wrong_name,
    "after > 1.05": lambda o: o.decided_ratio > 1.05,
}


@contextmanager
def scaled(name: str, factor: float) -> Iterator[object]:
    """The threshold of that name times factor, in every module that holds it; as it was behind the block."""
    value = TABLE[name]
    other = _scaled(value, factor)
    holders = [
        module
        for key, module in list(sys.modules.items())
        if key.startswith(("gravcomp.diagnosis", "gravcomp.logs")) and name in vars(module)
    ]
    for module in holders:
        setattr(module, name, other)
    try:
        yield other
    finally:
        for module in holders:
            setattr(module, name, value)


def _scaled(value, factor: float):
    if isinstance(value, dict):
        return {name: _times(x, factor) for name, x in value.items()}
    return tuple(_times(x, factor) for x in value) if isinstance(value, tuple) else _times(value, factor)


def _times(value: float, factor: float) -> float:
    return max(round(value * factor), 1) if isinstance(value, int) else value * factor


def outcomes(cases: list[tuple[str, int]]) -> list[OpenedSet]:
    return [run_model_case(kind, seed) for kind, seed in cases]


def row(name: str, factor: float, usual: list[OpenedSet], other: list[OpenedSet]) -> str:
    """How many sets end with other names, and what that does to the counts of a tally."""
    changed = sum(
        (a.named, a.listed, a.driver) != (b.named, b.listed, b.driver) for a, b in zip(usual, other, strict=True)
    )
    counts = ", ".join(f"{what} {_sum(is_so, usual)} -> {_sum(is_so, other)}" for what, is_so in _COUNTS.items())
    return f"{name} x {factor:g}: {changed} of {len(usual)} sets differ; {counts}"


def _sum(is_so, own: list[OpenedSet]) -> int:
    return sum(bool(is_so(o)) for o in own)
