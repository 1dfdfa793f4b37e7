"""From a machine folder and a board to a bitstream: GHDL, Yosys, nextpnr and ecppack, each checked."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.robot.machine import load_machine
from gravcomp_lab.boards.board import Board
from gravcomp_lab.synthesis.place_route import run_tool
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


def build(board: Board, weights: Path, rtl: Path, out: Path, *, selftest: bool, seed: int) -> Bitstream:
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
        _place(board, netlist.json, out, seed)
        used, clocks = _report(out / "report.json")
        _check_clocks(clocks, out)
        begin("pack")
        run_tool("ecppack", ["--compress", "--input", "placed.config", "--bit", "board.bit"], out)
        begin("unpack")
        run_tool("ecpunpack", ["--input", "board.bit", "--textcfg", "unpacked.config"], out)
        _check_unpacked(out / "placed.config", out / "unpacked.config")
        (out / "board.bit").replace(packed)
    return Bitstream(packed, used, clocks)


def _check_machine(board: Board, weights: Path) -> None:
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


def _place(board: Board, netlist: Path, out: Path, seed: int) -> None:
    (out / "board.lpf").write_bytes(board.constraints.read_bytes())
    arguments = [f"--{board.device}", "--package", board.package, "--speed", str(board.speed), "--seed", str(seed)]
    arguments += [
        "--json",
        netlist.name,
        "--lpf",
        "board.lpf",
        "--textcfg",
        "placed.config",
        "--report",
        "report.json",
        "--router",
        "router2",
    ]
    run_tool("nextpnr-ecp5", [*arguments, "--timing-allow-fail", "--quiet", "--log", "nextpnr.log"], out)


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
    """Raise InputError unless the bitstream holds every LUT, RAM and flip-flop setting that was placed."""
    before, after = _words(placed), _words(unpacked)
    if wrong := [place for place in before if after.get(place) != before[place]]:
        raise InputError(
            f"{unpacked}: {len(wrong)} of {len(before)} words are not what was placed, such as {' '.join(wrong[0])}"
        )


def _words(config: Path) -> dict[tuple[str, str], str]:
    """The words of a textual configuration, such as the table of a LUT, by tile and name."""
    tile, words = "", {}
    for line in config.read_text().splitlines():
        if line.startswith((".tile ", ".bram_init ")):
            tile = line
        elif found := re.fullmatch(r"word: (\S+) ([01]+)", line):
            words[tile, found[1]] = found[2]
    return words
