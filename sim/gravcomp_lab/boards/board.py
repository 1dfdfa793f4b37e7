"""A board of boards/: what its board.toml says of pins, clocks and parts."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError

# Every board is made of these, in compile order.
COMMON = ("gc_pll", "gc_power_on", "gc_desk_axis", "gc_board")
# By family: what names a part to its tools, see gravcomp_lab.boards.family.
PART_KEYS = {"ecp5": ("device", "package", "speed"), "gowin": ("device", "chip")}


@dataclass(frozen=True)
class BoardPart:
    """One part of one board: its top entity, files, clocks, and the generics that its part has room for.

    primitives: Verilog that takes the place of modules of the same name, with the part's own cells. axes: those that
    the pins are enough for. loader: the board's name for openFPGALoader. family: one of PART_KEYS. part: what names it
    to the tools of that.
    """

    name: str
    top: str
    sources: tuple[Path, ...]
    constraints: Path
    primitives: tuple[Path, ...]
    oscillator_hz: float
    core_hz: float
    axes: int
    loader: str
    family: str
    part: Mapping[str, int | str]
    generics: Mapping[str, int | str]


def boards(folder: Path) -> dict[str, BoardPart]:
    """All boards of a folder, a name for each part; InputError when there is none, or a key is missing."""
    found = {}
    for path in sorted(folder.glob("*/board.toml")):
        entries = tomllib.loads(path.read_text())
        for part, of_part in entries.get("parts", {}).items():
            name = f"{path.parent.name}-{part}"
            try:
                if entries["family"] not in PART_KEYS:
                    raise InputError(f"{path}: family = {entries['family']!r}; take one of {', '.join(PART_KEYS)}")
                found[name] = _board(name, path.parent, entries, of_part)
            except KeyError as missing:
                raise InputError(f"{path}: no key {missing.args[0]}; see the other boards") from None
    if not found:
        raise InputError(f"{folder}: no boards; give the folder of */board.toml")
    return found


def _board(name: str, folder: Path, entries: dict, part: dict) -> BoardPart:
    common = folder.parent / "common"
    return BoardPart(
        name=name,
        top=entries["top"],
        sources=(*(common / f"{entity}.vhd" for entity in COMMON), folder / f"{entries['top']}.vhd"),
        constraints=folder / entries["constraints"],
        primitives=tuple(folder / file for file in entries["primitives"]),
        oscillator_hz=entries["oscillator_hz"],
        core_hz=entries["core_hz"],
        axes=entries["axes"],
        loader=entries["loader"],
        family=entries["family"],
        part={key: part[key] for key in PART_KEYS[entries["family"]]},
        generics={key: str(value).lower() for key, value in part["generics"].items()},
    )
