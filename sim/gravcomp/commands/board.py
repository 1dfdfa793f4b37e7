"""Find, check and drive a core behind a serial port: gc_serial_system on a board.

Baud, parity and unit are those that the core was built with. A frame without an answer is sent again. Whatever ends
`hold`, `move` and `record`, the brakes are engaged then: Ctrl-C, a fault, and a line that is cut, because the core's
watchdog is kicked through it.
"""

import argparse
import contextlib
import sys
from pathlib import Path

from gravcomp.errors import InputError

VERBS = {
    "info": "what the core is, and its state",
    "home": "arm homing, and say which axes were moved over their index by hand",
    "hold": "release the brakes and hold until Ctrl-C",
    "move": "release the brakes, move to poses under the core's servo, hold at each; with --out what was measured",
    "record": "release the brakes, hold under the core's servo, and write what was measured",
    "load": "bring the constants of another machine folder into use",
    "watch": "positions, forces, currents and state, until Ctrl-C",
    "selftest": "check line, registers, clocks and results, with the brakes engaged",
}


def add_arguments(parser):
    parser.add_argument("port", help="serial device, COM port, or URL of pyserial")
    line = argparse.ArgumentParser(add_help=False)
    add_line(line)
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="verb")
    for name, text in VERBS.items():
        verb = verbs.add_parser(name, parents=[line], help=text, description=text)
        if name in ("home", "hold", "move", "record"):
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
        if name in ("move", "record"):
            _add_motion(verb, name)


class _Pose(argparse.Action):
    """Keeps poses in the order in which they are given, whichever way: (option, numbers), the option in full."""

    def __call__(self, parser, namespace, values, option_string=None):
        setattr(namespace, self.dest, [*(getattr(namespace, self.dest) or ()), (self.option_strings[0], values)])


def _add_motion(verb, name: str) -> None:
    if name == "move":
        verb.add_argument("--to", type=float, nargs="+", action=_Pose, dest="poses", metavar="Q",
                          help="a pose, m or rad per axis; once for each pose")  # fmt: skip
        verb.add_argument("--orientation", type=float, nargs="+", action=_Pose, dest="poses", metavar="DEG",
                          help="a pose as orientation, deg, where the robot takes one: elevation (around the base "
                          "circle), azimuth (size of the tilt), torsion of the Sphe.I.Ro.")  # fmt: skip
        verb.add_argument("--hold", type=float, default=1.0, help="seconds at each pose (default %(default)s)")
    text = "of each move, longer where a limit needs it" if name == "move" else "to record for"
    verb.add_argument("--seconds", type=float, default=2.0, help=f"seconds {text} (default %(default)s)")
    verb.add_argument("--out", type=Path, required=name == "record", help="measured CSV to write")
    verb.add_argument("--commanded", action="store_true",
                      help="commanded currents for measured ones, of drives that tell none")  # fmt: skip


def run(arguments):
    from gravcomp.driver.board import Board

    _check(arguments)
    with Board(line_of(arguments)) as board:
        if getattr(arguments, "robot", None):
            board.check_machine(arguments.robot)
        try:
            globals()[f"_{arguments.verb}"](board, arguments)
        except KeyboardInterrupt:
            print(file=sys.stderr)
        if board.bus.repeated:
            print(f"line: {board.bus.repeated} of {board.bus.sent} frames sent again", file=sys.stderr)


def add_line(parser) -> None:
    """The arguments that say what the line to a core is like."""
    parser.add_argument("--baud", type=int, default=115_200, help="bits per second (default %(default)s)")
    parser.add_argument("--parity", choices=("none", "odd", "even"), default="none", help="default %(default)s")
    parser.add_argument("--unit", type=int, default=1, help="address on the line (default %(default)s)")
    parser.add_argument(
        "--timeout", type=float, default=0.3, help="seconds to wait for an answer (default %(default)s)"
    )


def line_of(arguments):
    """The Line of arguments.port and those of add_line. Raises InputError for one that cannot be."""
    from gravcomp.driver.serial_bus import Line

    if not 1200 <= arguments.baud <= 3_000_000:
        raise InputError(f"--baud {arguments.baud}: need 1200 to 3000000")
    if not 1 <= arguments.unit <= 247:
        raise InputError(f"--unit {arguments.unit}: need 1 to 247")
    if not 0 < arguments.timeout <= 3600:
        raise InputError(f"--timeout {arguments.timeout:g}: need more than 0 seconds, 3600 at most")
    return Line(arguments.port, arguments.baud, arguments.parity, arguments.unit, arguments.timeout)


def _check(arguments) -> None:
    seconds = getattr(arguments, "seconds", None)
    if seconds is not None and not seconds > 0:
        raise InputError(f"--seconds {seconds:g}: need more than 0")
    if arguments.verb == "move" and not arguments.poses:
        raise InputError("no pose to move to; give --to or --orientation, once for each")
    if not getattr(arguments, "hold", 0.0) >= 0:
        raise InputError(f"--hold {arguments.hold:g}: need 0 or more")


def _info(board, arguments) -> None:
    identity, state = board.identity, board.host.read()
    bank, crc = ("ROM", 0) if not (crc := board.host.bank_crc()) else ("image", crc)
    print(f"{board.bus.line}")
    print(f"core       {identity.axes} axes, {identity.hidden} neurons, {identity.lanes} per clock"
          f"{', lean form' if identity.lean else ''}, {identity.clock_hz / 1e6:g} MHz")  # fmt: skip
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


def _move(board, arguments) -> None:
    _go(board, arguments, arguments.poses, arguments.seconds, arguments.hold)


def _record(board, arguments) -> None:
    _go(board, arguments, [], 0.0, arguments.seconds)


def _go(board, arguments, poses: list[tuple[str, list[float]]], move_s: float, hold_s: float) -> None:
    from gravcomp.driver.board import load_limits
    from gravcomp.driver.moving import Mover, load_motion

    limits = load_limits(arguments.limits, arguments.robot)
    mover = Mover(board, limits, load_motion(arguments.limits, arguments.robot))
    targets, units = [_counts(*pose, arguments.robot) for pose in poses], _units(arguments)
    try:
        for state in mover.go(targets, move_s, hold_s):
            _progress(state, units)
    finally:
        print(file=sys.stderr)
        if arguments.out:
            _write_records(mover, arguments)


def _counts(option: str, pose: list[float], folder: Path) -> tuple[int, ...]:
    """Counts of a pose in m or rad, or of an orientation in degrees."""
    import numpy as np

    from gravcomp.robot.machine import load_machine
    from gravcomp.robot.orientation import positions_at

    machine, where = load_machine(folder), f"{option} {' '.join(f'{q:g}' for q in pose)}"
    if option == "--orientation":
        q = positions_at(machine, np.array(pose), where)
    elif len(pose) != machine.n_axes or not np.isfinite(pose).all():
        raise InputError(f"{where}: need a number for each of {machine.n_axes} axes")
    else:
        q = np.array(pose)
    return tuple(machine.drive.counts(q).tolist())


def _progress(state, units) -> None:
    """Positions on one line of the terminal, over and over."""
    places = "  ".join(f"{n * k:.6g} {unit}" for n, (k, unit, _) in zip(state.position_now, units, strict=True))
    print(f"\r{places}\x1b[K", end="", file=sys.stderr, flush=True)


def _write_records(mover, arguments) -> None:
    """The measured CSV of what was taken, also when it ended early."""
    from dataclasses import replace

    from gravcomp.files import write_atomically
    from gravcomp.logs.records import measured_csv
    from gravcomp.robot.machine import load_machine

    records = mover.records()
    if not len(records.tick):
        return
    if arguments.commanded:
        records = replace(records, sense=records.command, is_stale=records.is_stale & False)
    write_atomically(arguments.out, measured_csv(records, load_machine(arguments.robot), mover.tick_s))
    lost = f", {mover.lost} more found no room" if mover.lost else ""
    print(f"{arguments.out}: {len(records.tick)} records{lost}")


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
    """Each state over the one before on a terminal, one line per state elsewhere, for arguments.seconds or until an
    interrupt.
    """
    import time

    from gravcomp.driver.interrupts import interrupts

    units, end = _units(arguments), time.monotonic() + (arguments.seconds or float("inf"))
    is_terminal, shown = sys.stdout.isatty(), 0
    with interrupts() as is_interrupted, contextlib.closing(states):
        for state in states:
            lines = _state_lines(state, units)
            if is_terminal:
                print(f"\x1b[{shown}A\x1b[J" * bool(shown) + "\n".join(lines), flush=True)
                shown = len(lines)
            else:
                print(" | ".join(" ".join(line.split()) for line in lines), flush=True)
            if is_interrupted() or time.monotonic() >= end:
                break


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
