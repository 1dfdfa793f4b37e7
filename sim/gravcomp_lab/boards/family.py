"""A family of parts: what its tools do between a netlist and a bitstream."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from gravcomp_lab.boards.board import BoardPart
from gravcomp_lab.synthesis.yosys import Netlist


@dataclass(frozen=True)
class Family:
    """Tools of a family; each raises InputError when one fails.

    target: of gravcomp_lab.synthesis.yosys. modules: files of rtl with the family's own form of a module. suffix: of
    its bitstreams.
    place: (board, netlist, seed, folder) -> nextpnr's report; pins and clocks are those of the board.
    pack: (board, name of the bitstream, folder), of what was placed there.
    compare: (board, name of the bitstream, folder): unpacks it, and raises InputError when it is not what was placed.
    """

    target: str
    modules: tuple[Path, ...]
    suffix: str
    place: Callable[[BoardPart, Netlist, int, Path], Path]
    pack: Callable[[BoardPart, str, Path], None]
    compare: Callable[[BoardPart, str, Path], None]
