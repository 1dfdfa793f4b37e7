"""Gowin: nextpnr-himbaechel, then gowin_pack and gowin_unpack of Project Apicula."""

import json
import re
from collections.abc import Mapping
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.boards.board import BoardPart
from gravcomp_lab.boards.family import Family
from gravcomp_lab.synthesis.place_route import (
    GOWIN_PINS,
    GOWIN_PLACED,
    NEXTPNR_GOWIN,
    gowin_options,
    run_nextpnr,
    run_tool,
)
from gravcomp_lab.synthesis.yosys import Netlist

_CLOCKS, _UNPACKED = "clocks.sdc", "unpacked.v"


def _place(board: BoardPart, netlist: Netlist, seed: int, out: Path) -> Path:
    """Place and route in folder out, pins as in the board's constraints (CST), clocks as in board.toml: the report."""
    options = [*gowin_options(**board.part), "--sdc", _CLOCKS]
    inputs = {GOWIN_PINS: _pins(board, netlist.port_widths()), _CLOCKS: _clocks(board)}
    return run_nextpnr(NEXTPNR_GOWIN, netlist.json, options, seed, out, inputs=inputs, results=[GOWIN_PLACED])


def _pins(board: BoardPart, widths: Mapping[str, int]) -> str:
    """The board's constraints for ports of these widths: nextpnr names a vector of one bit without its index."""
    text = board.constraints.read_text()
    for name in (name for name, width in widths.items() if width == 1):
        text = text.replace(f'"{name}[0]"', f'"{name}"')
    return text


def _clocks(board: BoardPart) -> str:
    """Constraints (SDC) of the two clocks of gc_board: nextpnr takes none through a pad or a PLL."""
    rates = {"i_board.clk_osc": board.oscillator_hz, "i_board.clk": board.core_hz}
    return "".join(f"create_clock -period {1e9 / hz:.6f} [get_nets {{{net}}}]\n" for net, hz in rates.items())


def _pack(board: BoardPart, file: str, out: Path) -> None:
    """Pack what was placed in folder out; the pins of the slave SPI, which configures no board, are the design's."""
    run_tool("gowin_pack", ["-d", str(board.part["chip"]), "--sspi_as_gpio", "-o", file, GOWIN_PLACED], out)


def _compare(board: BoardPart, file: str, out: Path) -> None:
    """Unpack a bitstream; InputError when its LUTs and flip-flops are not those that were placed."""
    run_tool("gowin_unpack", ["-d", str(board.part["chip"]), "--noalu", "-o", _UNPACKED, file], out)
    check_unpacked(out / GOWIN_PLACED, out / _UNPACKED)


def check_unpacked(placed: Path, unpacked: Path) -> None:
    """Raise InputError unless the unpacked file has every table and kind of flip-flop of the placed design.

    gowin_unpack tells nothing of block RAMs, and of an adder's mode (ALU_MODE) only with guesses: those are not
    compared.
    """
    before, after = _placed(placed), _unpacked(unpacked)
    wrong = [f"{place} {value}" for place, value in before.items() if after.get(place, _ERASED) != value]
    if wrong:
        raise InputError(
            f"{unpacked}: {len(wrong)} of {len(before)} settings are not what was placed, such as {wrong[0]}"
        )


# Of a table without a fuse set, which an unpacked file leaves out.
_ERASED = "1" * 16


def _placed(path: Path) -> Mapping[str, str]:
    """By place, R<row>C<column>_<LUT or DFF>_<number>: the 16 bits of a table, the kind of a flip-flop."""
    (top,) = (module for module in json.loads(path.read_text())["modules"].values())
    found = {}
    for cell in top["cells"].values():
        bel = re.fullmatch(r"X(\d+)Y(\d+)/(LUT|ALU|DFF)(\d)", cell["attributes"].get("NEXTPNR_BEL", ""))
        if not bel:
            continue
        where, parameters = f"R{int(bel[2]) + 1}C{int(bel[1]) + 1}_{{}}_{bel[4]}", cell["parameters"]
        if bel[3] == "DFF":
            found[where.format("DFF")] = _kind(cell["type"])
        elif table := parameters.get("INIT", parameters.get("RAW_ALU_LUT")):
            found[where.format("LUT")] = table[-16:] * (16 // min(16, len(table)))
    return found


def _unpacked(path: Path) -> Mapping[str, str]:
    text = path.read_text()
    tables = re.findall(r"^defparam (R\d+C\d+_LUT)4(_\d)\.INIT = 16'h(\w{4});", text, re.MULTILINE)
    found = {place + number: f"{int(table, 16):016b}" for place, number, table in tables}
    zeros = re.findall(r"^assign (R\d+C\d+_)F(\d) = VSS;", text, re.MULTILINE)
    found |= {f"{place}LUT_{number}": "0" * 16 for place, number in zeros}
    flip_flops = re.findall(r"^(DFF\w*) (R\d+C\d+_)DFF\w*_(\d) \(", text, re.MULTILINE)
    return found | {f"{place}DFF_{number}": _kind(kind) for kind, place, number in flip_flops}


def _kind(flip_flop: str) -> str:
    """Edge and reset of a flip-flop; an enable that is always on is unpacked as one that is used."""
    return flip_flop.removesuffix("E")


GOWIN = Family("gw2a", (), ".fs", _place, _pack, _compare)
