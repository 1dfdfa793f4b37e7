"""Find, check and drive a core behind a serial port: gc_serial_system on a board.

Baud, parity and unit are those that the core was built with. A frame without an answer is sent again. Whatever ends
`hold`, the brakes are engaged then: Ctrl-C, a fault, and a line that is cut, because the core's watchdog is kicked
through it.
"""

import argparse
import sys
from pathlib import Path

from gravcomp.errors import InputError

VERBS = {
    "info": "what the core is, and its state",
    "home": "arm homing, and say which axes were moved over their index by hand",
    "hold": "release the brakes and hold until Ctrl-C",
    "move": "move to a pose: needs gc_servo",
    "record": "record a log: needs gc_recorder",
    "load": "bring the constants of another machine folder into use",
    "watch": "positions, forces, currents and state, until Ctrl-C",
    "selftest": "check line, registers, clocks and results, with the brakes engaged",
}
LATER = {"move": "gc_servo", "record": "gc_recorder"}


def add_arguments(parser):
    parser.add_argument("port", help="serial device, COM port, or URL of pyserial")
    line = argparse.ArgumentParser(add_help=False)
    line.add_argument("--baud", type=int, default=115_200, help="bits per second (default %(default)s)")
    line.add_argument("--parity", choices=("none", "odd", "even"), default="none", help="default %(default)s")
    line.add_argument("--unit", type=int, default=1, help="address on the line (default %(default)s)")
    line.add_argument("--timeout", type=float, default=0.3, help="seconds to wait for an answer (default %(default)s)")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="verb")
    for name, text in VERBS.items():
        verb = verbs.add_parser(name, parents=[line], help=text, description=text)
        if name in ("home", "hold"):
            verb.add_argument("--robot", type=Path, required=True, help="machine folder that the core was built with")
            verb.add_argument(
                "--limits", type=Path, required=True, help="TOML file of limits, see docs/guide/serial.md"
            )
        if name in ("info", "watch"):
            verb.add_argument("--robot", type=Path, help="machine folder, to compare with the core, and for units")
        if name == "load":
            verb.add_argument("--weights", type=Path, required=True, help="machine folder to load")
            verb.add_argument("--robot", type=Path, required=True, help="machine folder that the core was built with")
        if name in ("hold", "watch"):
            verb.add_argument("--seconds", type=float, help="end after so long (default: at Ctrl-C)")


def run(arguments):
    from gravcomp.driver.board import Board
    from gravcomp.driver.serial_bus import Line

    if arguments.verb in LATER:
        raise InputError(f"{arguments.verb}: needs {LATER[arguments.verb]}, which this version of the core has not; "
                         "hold and watch are there")  # fmt: skip
    _check(arguments)
    line = Line(arguments.port, arguments.baud, arguments.parity, arguments.unit, arguments.timeout)
    with Board(line) as board:
        if getattr(arguments, "robot", None):
            board.check_machine(arguments.robot)
        try:
            globals()[f"_{arguments.verb}"](board, arguments)
        except KeyboardInterrupt:
            print(file=sys.stderr)
        if board.bus.repeated:
            print(f"line: {board.bus.repeated} of {board.bus.sent} frames sent again", file=sys.stderr)


def _check(arguments) -> None:
    if not 1200 <= arguments.baud <= 3_000_000:
        raise InputError(f"--baud {arguments.baud}: need 1200 to 3000000")
    if not 1 <= arguments.unit <= 247:
        raise InputError(f"--unit {arguments.unit}: need 1 to 247")
    if not 0 < arguments.timeout <= 3600:
        raise InputError(f"--timeout {arguments.timeout:g}: need more than 0 seconds, 3600 at most")
    seconds = getattr(arguments, "seconds", None)
    if seconds is not None and not seconds > 0:
        raise InputError(f"--seconds {seconds:g}: need more than 0")


def _info(board, arguments) -> None:
    identity, state = board.identity, board.host.read()
    bank, crc = ("ROM", 0) if not (crc := board.host.bank_crc()) else ("image", crc)
    print(f"{board.bus.line}")
    print(f"core       {identity.axes} axes, {identity.hidden} neurons, {identity.lanes} per clock, "
          f"{identity.clock_hz / 1e6:g} MHz")  # fmt: skip
    print(f"weights    {identity.weights_hash[0]:08x} in the ROM"
          + (f", those of {arguments.robot}" if arguments.robot else ""))  # fmt: skip
    print(f"in use     {bank}" + (f", CRC-32 {crc:08x}" if crc else ""))
    print(f"clock      {'runs' if board.host.core_runs() else 'STANDS: what follows is old'}")
    for line in _state_lines(state, _units(arguments)):
        print(line)
    counts = board.counts()
    print("line       " + ", ".join(f"{n} {name}" for name, n in counts.items()))


def _home(board, arguments) -> None:
    from gravcomp.driver.board import load_limits

    print("move every axis over its index by hand; brakes are engaged, release them as your robot's manual says")
    known = None
    for state in board.home(load_limits(arguments.limits, arguments.robot)):
        if state.referenced != known:
            known = state.referenced
            done = [str(axis + 1) for axis in range(len(state.position)) if known >> axis & 1]
            print(f"referenced: {', '.join(done) or 'none'} of {len(state.position)} axes", flush=True)


def _hold(board, arguments) -> None:
    from gravcomp.driver.board import load_limits

    _show(board.hold(load_limits(arguments.limits, arguments.robot)), arguments)


def _watch(board, arguments) -> None:
    def states():
        while True:
            yield board.host.read()

    _show(states(), arguments)


def _load(board, arguments) -> None:
    from tqdm import tqdm

    from gravcomp.core.image import load_image

    image = load_image(arguments.weights, arguments.robot)
    with tqdm(total=len(image.words), unit="word", desc="load", disable=None) as bar:
        crc = board.load(image, bar.update)
    print(f"in use: {arguments.weights}, {len(image.words)} words, CRC-32 {crc:08x}")


def _selftest(board, arguments) -> None:
    failed = []
    for check in board.selftest():
        print(f"{'ok    ' if check.is_right else 'FAILED'} {check.name}: {check.found}", flush=True)
        failed += [] if check.is_right else [check.name]
    if failed:
        raise InputError(f"{board.bus.line}: failed: {', '.join(failed)}; see docs/guide/serial.md")


def _show(states, arguments) -> None:
    """Each state over the one before on a terminal, one line per state elsewhere, for arguments.seconds."""
    import time

    units, end = _units(arguments), time.monotonic() + (arguments.seconds or float("inf"))
    is_terminal, shown = sys.stdout.isatty(), 0
    try:
        for state in states:
            lines = _state_lines(state, units)
            if is_terminal:
                print(f"\x1b[{shown}A\x1b[J" * bool(shown) + "\n".join(lines), flush=True)
                shown = len(lines)
            else:
                print(" | ".join(" ".join(line.split()) for line in lines), flush=True)
            if time.monotonic() >= end:
                break
    finally:
        states.close()


def _units(arguments) -> list[tuple[float, str, str]] | None:
    """Per axis: positions of a count in mm or degrees, that unit, and that of the effort; None: no machine is given."""
    import math

    from gravcomp.robot.machine import load_machine

    if not arguments.robot:
        return None
    machine = load_machine(arguments.robot)
    scales = {"m": (1e3, "mm", "N"), "rad": (180 / math.pi, "deg", "Nm")}
    per_count = machine.drive.unit_per_count
    return [(float(k) * scales[u][0], *scales[u][1:]) for k, u in zip(per_count, machine.position_units, strict=True)]


def _state_lines(state, units) -> list[str]:
    from gravcomp.facts import Cause, State

    faults = [cause.name.lower() for cause in Cause if state.fault >> cause & 1]
    lines = [f"state      {State(state.brakes).name.lower()}, result {state.result_number}, faults: "
             + (", ".join(faults) or "none")]  # fmt: skip
    units = units or [(1.0, "counts", "effort")] * len(state.position)
    for axis, (scale, unit, effort) in enumerate(units):
        flags = [name for name in ("referenced", "clamped", "saturated", "limited") if getattr(state, name) >> axis & 1]
        lines.append(f"axis {axis + 1}     {state.position_now[axis] * scale:12.6g} {unit}  "
                     f"{state.force_mn[axis] / 1e3:9.3f} {effort}  {state.command_ua[axis] / 1e6:9.6f} A  "
                     + " ".join(flags))  # fmt: skip
    return lines
