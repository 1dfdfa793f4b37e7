"""Synthesis with Yosys (pyosys): cell counts and netlists for a target."""

import json
import subprocess
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.synthesis.around import AROUND, Ports, Wrapper

# Passes after reading. The area of 7-series and Gowin parts is an estimate: Yosys' counts, not placed.
TARGETS = {
    "generic": ["flatten", "opt -full", "memory -nomap", "opt_clean"],
    "gates": ["synth -flatten -top {top}"],
    "ecp5": ["synth_lattice -family ecp5 -top {top}"],
    "xilinx": ["synth_xilinx -family xc7 -flatten -noiopad -noclkbuf -top {top}"],
    "gowin": ["synth_gowin -family gw2a -noiopads -top {top}"],
    # With pads, to be placed; the iCE40 is an UltraPlus.
    "ice40": ["synth_ice40 -dsp -device u -top {top}"],
    "gw1n": ["synth_gowin -family gw1n -top {top}"],
    "gw2a": ["synth_gowin -family gw2a -top {top}"],
}
# The primitives that a mapping file may use.
PRIMITIVES = {
    "ecp5": ["+/lattice/cells_bb_ecp5.v"],
    "xilinx": ["+/xilinx/cells_sim.v"],
    "gw2a": ["+/gowin/cells_sim.v"],
}

# GHDL drops attributes: that which keeps the copies of gc_copy apart, and that which tells that gc_bank_ram never reads
# what it writes in the same clock.
_ATTRIBUTES = ["setattr -set keep 1 gc_copy*/t:$dff", "setattr -set no_rw_check 1 gc_bank_ram*/m:*"]

# Yosys ends the process on an error, so it runs in one of its own.
RUNNER = """
import sys
from pyosys import libyosys
design = libyosys.Design()
for line in open(sys.argv[1]):
    libyosys.run_pass(line.strip(), design)
"""


@dataclass(frozen=True)
class Netlist:
    """A synthesised design: its top module, number of cells by type, and the netlist as JSON and as Verilog.

    ports: of the design that something was put around, those that are used and not left open.
    """

    top: str
    cells: dict[str, int]
    json: Path
    verilog: Path
    ports: Ports = field(default_factory=dict)

    def port_bits(self) -> int:
        """Bits of all ports of the top."""
        return sum(self.port_widths().values())

    def port_widths(self) -> dict[str, int]:
        """Bits of each port of the top."""
        ports = json.loads(self.json.read_text())["modules"][self.top]["ports"]
        return {name: len(port["bits"]) for name, port in ports.items()}


def synthesise(
    verilog: Path,
    top: str,
    target: str,
    out: Path,
    *,
    mapping: Path | Sequence[Path] | None = None,
    around: Wrapper | None = None,
    open_ports: Collection[str] = (),
) -> Netlist:
    """Synthesise module top of a Verilog file for a target of TARGETS; files and yosys.log go to the folder out.

    mapping: Verilog files whose modules replace those of the same name, such as the vendor's form of a multiplier.
    around: what stands around the top, of gravcomp_lab.synthesis.around, so that place and route times the paths
    through its ports too; the top of the netlist is then that. open_ports: outputs that nothing is to take then.
    Raises InputError when Yosys fails; a latch is a failure.
    """
    out.mkdir(parents=True, exist_ok=True)
    read = [f"read_verilog {verilog.resolve()}"]
    if mapping:
        read += [f"read_verilog -lib {path}" for path in PRIMITIVES.get(target, [])]
        files = [mapping] if isinstance(mapping, Path) else mapping
        read += [f"read_verilog -overwrite {file.resolve()}" for file in files]
    ports = {}
    if around:
        ports = {name: port for name, port in _ports(read, top, out).items() if name not in open_ports}
        wrapper = out / "around.v"
        wrapper.write_text(around(top, ports))
        read, top = [*read, f"read_verilog {wrapper.resolve()}"], AROUND
    netlist, mapped, cells = (out / f"{target}.{name}" for name in ("json", "v", "stat.json"))
    passes = [*read, f"hierarchy -check -top {top}", "proc -latches error", *_ATTRIBUTES, *TARGETS[target]]
    passes += [f"tee -q -o {cells.name} stat -json"]
    passes += [f"write_json {netlist.name}", f"write_verilog -noattr {mapped.name}"]
    run_passes([line.format(top=top) for line in passes], out / "yosys.log")
    counts = json.loads(cells.read_text())["design"]["num_cells_by_type"]
    return Netlist(top, {name: int(number) for name, number in counts.items()}, netlist, mapped, ports)


def _ports(read: Sequence[str], top: str, out: Path) -> Ports:
    """The ports of module top that a cell uses or drives."""
    passes = ["proc", "flatten", "opt", "write_json ports.json"]
    run_passes([*read, f"hierarchy -check -top {top}", *passes], out / "ports.log")
    module = json.loads((out / "ports.json").read_text())["modules"][top]
    in_use = {bit for cell in module["cells"].values() for bits in cell["connections"].values() for bit in bits}
    ports = {name: port for name, port in module["ports"].items() if in_use.intersection(port["bits"])}
    return {name: (port["direction"], len(port["bits"])) for name, port in ports.items()}


def run_passes(passes: Sequence[str], log: Path, timeout_s: float | None = None) -> None:
    """Run Yosys on a list of its commands in the folder of log; raises InputError when it fails, or takes longer."""
    script = log.with_suffix(".ys")
    script.write_text("\n".join(passes) + "\n")
    with log.open("w") as file:
        command = [sys.executable, "-c", RUNNER, script.name]
        try:
            done = subprocess.run(
                command, cwd=log.parent, stdout=file, stderr=subprocess.STDOUT, check=False, timeout=timeout_s
            )
        except subprocess.TimeoutExpired:
            raise InputError(f"yosys: not done in {timeout_s:g} s; see {log}") from None
    if done.returncode:
        message = next((line for line in reversed(log.read_text().splitlines()) if "ERROR" in line), "no message")
        raise InputError(f"yosys: {message.strip()}; see {log}")
