"""ECP5: nextpnr-ecp5, then ecppack and ecpunpack of Project Trellis."""

import re
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.boards.board import BoardPart
from gravcomp_lab.boards.family import Family
from gravcomp_lab.synthesis.place_route import NEXTPNR_ECP5, ecp5_options, run_nextpnr, run_tool
from gravcomp_lab.synthesis.survey import MULTIPLIER
from gravcomp_lab.synthesis.yosys import Netlist

_PLACED, _UNPACKED = "placed.config", "unpacked.config"


def _place(board: BoardPart, netlist: Netlist, seed: int, out: Path) -> Path:
    """Place and route in folder out, pins and clock as in the board's constraints (LPF): nextpnr's report."""
    options = [*ecp5_options(**board.part), "--router", "router1", "--lpf", "pins.lpf", "--textcfg", _PLACED]
    inputs = {"pins.lpf": board.constraints.read_text()}
    return run_nextpnr(NEXTPNR_ECP5, netlist.json, options, seed, out, inputs=inputs, results=[_PLACED])


def _pack(board: BoardPart, file: str, out: Path) -> None:
    """Pack what was placed in folder out."""
    run_tool("yowasp-ecppack", ["--compress", "--input", _PLACED, "--bit", file], out)


def _compare(board: BoardPart, file: str, out: Path) -> None:
    """Unpack a bitstream; InputError when it is not what was placed."""
    run_tool("yowasp-ecpunpack", ["--input", file, "--textcfg", _UNPACKED], out)
    check_unpacked(out / _PLACED, out / _UNPACKED)


def check_unpacked(placed: Path, unpacked: Path) -> None:
    """Raise InputError unless the bitstream holds every LUT, RAM word and flip-flop setting that was placed."""
    before, after = _settings(placed), _settings(unpacked)
    if wrong := [place for place, value in before.items() if after.get(place, _erased(place)) != value]:
        raise InputError(
            f"{unpacked}: {len(wrong)} of {len(before)} settings are not what was placed, such as {' '.join(wrong[0])}"
        )


def _settings(config: Path) -> dict[tuple[str, str], str]:
    """Of a textual configuration: tables of LUTs and values that flip-flops begin with, by tile and name; words of
    block RAMs, by number and row.

    A RAM's own settings are spread over tiles, of which ecpunpack reads one at a time: they cannot be compared.
    """
    block, row, found = "", 0, {}
    for line in config.read_text().splitlines():
        if line.startswith("."):
            block, row = line, 0
        elif block.startswith(".bram_init ") and line:
            found[block, f"row {row}"] = line
            row += 1
        elif own := re.fullmatch(r"(?:word|enum): (\S+\.(?:K\d\.INIT|REG\d\.REGSET)) (\w+)", line):
            found[block, own[1]] = own[2]
    return found


def _erased(place: tuple[str, str]) -> str | None:
    """What a setting is that a textual configuration leaves out: that of a chip without a bitstream."""
    name = place[1]
    return "1" * 16 if name.endswith(".INIT") else "SET" if name.endswith(".REGSET") else None


ECP5 = Family("ecp5", (MULTIPLIER,), ".bit", _place, _pack, _compare)
