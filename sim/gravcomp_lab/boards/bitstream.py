"""From a machine folder and a board to a bitstream: GHDL, Yosys, nextpnr and a packer, each checked."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isclose
from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.robot.machine import load_machine
from gravcomp_lab.boards.board import BoardPart
from gravcomp_lab.boards.ecp5 import ECP5
from gravcomp_lab.boards.gowin import GOWIN
from gravcomp_lab.synthesis.survey import machine_sources
from gravcomp_lab.synthesis.verilog import to_verilog
from gravcomp_lab.synthesis.yosys import synthesise

STEPS = ("ROM", "Verilog", "netlist", "place and route", "pack", "unpack")
FAMILIES = {"ecp5": ECP5, "gowin": GOWIN}


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
    family = FAMILIES[board.family]
    out.mkdir(parents=True, exist_ok=True)
    (packed := out / f"{board.name}{family.suffix}").unlink(missing_ok=True)
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
        mapping = (*(rtl / module for module in family.modules), *board.primitives)
        netlist = synthesise(verilog, board.top, family.target, out, mapping=mapping)
        begin("place and route")
        used, clocks = _report(family.place(board, netlist, seed, out))
        _check_clocks(board, clocks, out)
        begin("pack")
        file = f"board{family.suffix}"
        family.pack(board, file, out)
        begin("unpack")
        family.compare(board, file, out)
        (out / file).replace(packed)
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


def _check_clocks(board: BoardPart, clocks: tuple[Clock, ...], out: Path) -> None:
    """Raise InputError unless the board's two clocks were timed at what they run at, and reach it."""
    timed, runs = sorted(clock.asked_mhz for clock in clocks), sorted((board.oscillator_hz / 1e6, board.core_hz / 1e6))
    if len(timed) != len(runs) or not all(map(_is_rate, timed, runs)):
        raise InputError(
            f"{out / 'nextpnr.log'}: clocks of {_rates(timed)} MHz were timed, {board.name} runs at {_rates(runs)}: no "
            "bitstream; let the constraints name its clocks, and board.toml their rates"
        )
    for clock in clocks:
        if clock.reached_mhz < clock.asked_mhz:
            raise InputError(
                f"clock {clock.name} runs at {clock.asked_mhz:.1f} MHz, the placement reaches {clock.reached_mhz:.1f}: "
                f"no bitstream; try another --seed, or fewer lanes in board.toml; see {out / 'nextpnr.log'}"
            )


def _is_rate(timed: float, runs: float) -> bool:
    return isclose(timed, runs, rel_tol=1e-4)  # a period of whole ps in between


def _rates(mhz: Sequence[float]) -> str:
    return ", ".join(f"{rate:.1f}" for rate in mhz)
