"""From a machine folder and a board to a bitstream: GHDL, Yosys, nextpnr and ecppack, each checked."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.robot.machine import load_machine
from gravcomp_lab.boards.board import BoardPart
from gravcomp_lab.synthesis.place_route import CONFIG, run_nextpnr, run_tool
from gravcomp_lab.synthesis.survey import MULTIPLIER, machine_sources
from gravcomp_lab.synthesis.verilog import to_verilog
from gravcomp_lab.synthesis.yosys import synthesise

STEPS = ("ROM", "Verilog", "netlist", "place and route", "pack", "unpack")


@dataclass(frozen=True)
class Clock:
    """A clock of a placed design: its name, what it runs at, and what it could, MHz."""

    name: str
    asked_mhz: float
    reached_mhz: float


@dataclass(frozen=True)
class Bitstream:
    """A packed bitstream: its file, the cells used of those that there are, and the clocks."""

    file: Path
    used: Mapping[str, tuple[int, int]]
    clocks: tuple[Clock, ...]


def build(board: BoardPart, weights: Path, rtl: Path, out: Path, *, selftest: bool, seed: int) -> Bitstream:
    """Make a bitstream for a machine on a board; files go to the folder out.

    selftest: the desk's axes in place of the pins. Raises InputError when the machine does not fit the board, a tool
    fails, a clock is missed, or what was packed is not what was placed; there is no bitstream then.
    """
    _check_machine(board, weights)
    out.mkdir(parents=True, exist_ok=True)
    (packed := out / f"{board.name}.bit").unlink(missing_ok=True)
    with tqdm(total=len(STEPS), unit="step") as bar:

        def begin(step: str) -> None:
            bar.set_description(step)
            bar.n = STEPS.index(step)
            bar.refresh()

        begin("ROM")
        sources = [*machine_sources(rtl, weights, out), *board.sources]
        begin("Verilog")
        generics = {**board.generics, "selftest_g": str(selftest).lower()}
        verilog = to_verilog(sources, board.top, generics, out / "board.v")
        begin("netlist")
        mapping = (rtl / MULTIPLIER, *board.primitives)
        netlist = synthesise(verilog, board.top, "ecp5", out, mapping=mapping)
        begin("place and route")
        report = run_nextpnr(
            netlist.json, device=board.device, package=board.package, speed=board.speed, seed=seed, out=out,
            router="router1", constraints=board.constraints,
        )  # fmt: skip
        used, clocks = _report(report)
        _check_clocks(clocks, out)
        begin("pack")
        run_tool("ecppack", ["--compress", "--input", CONFIG, "--bit", "board.bit"], out)
        begin("unpack")
        run_tool("ecpunpack", ["--input", "board.bit", "--textcfg", "unpacked.config"], out)
        _check_unpacked(out / CONFIG, out / "unpacked.config")
        (out / "board.bit").replace(packed)
    return Bitstream(packed, used, clocks)


def _check_machine(board: BoardPart, weights: Path) -> None:
    machine = load_machine(weights)
    if machine.n_axes > board.axes:
        raise InputError(
            f"{weights}: {machine.n_axes} axes; {board.name} has pins for {board.axes}: take another board"
        )
    if machine.clock_hz != board.core_hz:
        raise InputError(
            f"{weights / 'robot.toml'}: clock_hz = {machine.clock_hz:g}, {board.name} runs its core at "
            f"{board.core_hz:g}; write that one there"
        )


def _report(path: Path) -> tuple[dict[str, tuple[int, int]], tuple[Clock, ...]]:
    found = json.loads(path.read_text())
    clocks = (Clock(name, of["constraint"], of["achieved"]) for name, of in found["fmax"].items())
    used = {name: (of["used"], of["available"]) for name, of in found["utilization"].items() if of["used"]}
    return used, tuple(clocks)


def _check_clocks(clocks: tuple[Clock, ...], out: Path) -> None:
    for clock in clocks:
        if clock.reached_mhz < clock.asked_mhz:
            raise InputError(
                f"clock {clock.name} runs at {clock.asked_mhz:.1f} MHz, the placement reaches {clock.reached_mhz:.1f}: "
                f"no bitstream; try another --seed, or fewer lanes in board.toml; see {out / 'nextpnr.log'}"
            )


def _check_unpacked(placed: Path, unpacked: Path) -> None:
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
