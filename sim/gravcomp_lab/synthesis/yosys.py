"""Synthesis with Yosys (pyosys): cell counts and netlists for a target."""

import json
import subprocess
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError

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
PRIMITIVES = {"ecp5": ["+/lattice/cells_bb_ecp5.v"], "xilinx": ["+/xilinx/cells_sim.v"]}

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

    scanned_inputs, scanned_outputs: bits of the chain around it, if there is one.
    """

    top: str
    cells: dict[str, int]
    json: Path
    verilog: Path
    scanned_inputs: int = 0
    scanned_outputs: int = 0

    def port_bits(self) -> int:
        """Bits of all ports of the top."""
        ports = json.loads(self.json.read_text())["modules"][self.top]["ports"]
        return sum(len(port["bits"]) for port in ports.values())


def synthesise(
    verilog: Path,
    top: str,
    target: str,
    out: Path,
    *,
    mapping: Path | Sequence[Path] | None = None,
    registered: bool = False,
    scanned: bool = False,
    open_ports: Collection[str] = (),
) -> Netlist:
    """Synthesise module top of a Verilog file for a target of TARGETS; files and yosys.log go to the folder out.

    mapping: Verilog files whose modules replace those of the same name, such as the vendor's form of a multiplier.
    registered: flip-flops around every port but clk, so that place and route times the paths through the ports too;
    the top of the netlist is then `registered`.
    scanned: these flip-flops as one shift register, for a part with fewer pins; the top is then `scanned`. open_ports:
    outputs that nothing is to take then.
    Raises InputError when Yosys fails; a latch is a failure.
    """
    out.mkdir(parents=True, exist_ok=True)
    read = [f"read_verilog {verilog.resolve()}"]
    if mapping:
        read += [f"read_verilog -lib {path}" for path in PRIMITIVES.get(target, [])]
        files = [mapping] if isinstance(mapping, Path) else mapping
        read += [f"read_verilog -overwrite {file.resolve()}" for file in files]
    chain = {"scanned_inputs": 0, "scanned_outputs": 0}
    if registered or scanned:
        ports = {name: port for name, port in _ports(read, top, out).items() if name not in open_ports}
        name = "scanned" if scanned else "registered"
        wrapper = out / f"{name}.v"
        wrapper.write_text((_scan_ports if scanned else _register_ports)(top, ports))
        read, top = [*read, f"read_verilog {wrapper.resolve()}"], name
        if scanned:
            chain = {f"scanned_{way}s": _bits(ports, way) for way in ("input", "output")}
    netlist, mapped, cells = (out / f"{target}.{name}" for name in ("json", "v", "stat.json"))
    passes = [*read, f"hierarchy -check -top {top}", "proc -latches error", *_ATTRIBUTES, *TARGETS[target]]
    passes += [f"tee -q -o {cells.name} stat -json"]
    passes += [f"write_json {netlist.name}", f"write_verilog -noattr {mapped.name}"]
    run_passes([line.format(top=top) for line in passes], out / "yosys.log")
    counts = json.loads(cells.read_text())["design"]["num_cells_by_type"]
    return Netlist(top, {name: int(number) for name, number in counts.items()}, netlist, mapped, **chain)


def _ports(read: Sequence[str], top: str, out: Path) -> dict[str, tuple[str, int]]:
    """Direction and width of each port of module top that a cell uses or drives."""
    passes = ["proc", "flatten", "opt", "write_json ports.json"]
    run_passes([*read, f"hierarchy -check -top {top}", *passes], out / "ports.log")
    module = json.loads((out / "ports.json").read_text())["modules"][top]
    in_use = {bit for cell in module["cells"].values() for bits in cell["connections"].values() for bit in bits}
    ports = {name: port for name, port in module["ports"].items() if in_use.intersection(port["bits"])}
    return {name: (port["direction"], len(port["bits"])) for name, port in ports.items()}


def _register_ports(top: str, ports: dict[str, tuple[str, int]]) -> str:
    """Verilog of module `registered`: top with a flip-flop at every port but clk."""
    around = {name: port for name, port in ports.items() if name != "clk"}
    declared = [f"{way} [{bits - 1}:0] {name}" for name, (way, bits) in around.items()]
    signals = [f"  reg [{bits - 1}:0] {name}_q; wire [{bits - 1}:0] {name}_d;" for name, (_, bits) in around.items()]
    moves, connections = [], []
    for name, (way, _) in around.items():
        inside = "q" if way == "input" else "d"
        moves += [f"  always @(posedge clk) {name}_q <= {name}_d;"]
        moves += [f"  assign {name}_d = {name};" if way == "input" else f"  assign {name} = {name}_q;"]
        connections += [f".{name}({name}_{inside})"]
    head = f"module registered(input clk, {', '.join(declared)});"
    core = f"  {top} core(.clk(clk), {', '.join(connections)});"
    return "\n".join([head, *signals, *moves, core, "endmodule", ""])


def _scan_ports(top: str, ports: dict[str, tuple[str, int]]) -> str:
    """Verilog of module `scanned`: top with its ports but clk on a shift register, which captures the outputs."""
    n_in, n_out = _bits(ports, "input"), _bits(ports, "output")
    connections, low = [".clk(clk)"], {"input": 0, "output": 0}
    for name, (way, bits) in ports.items():
        if name != "clk":
            signal = "in_q" if way == "input" else "out_d"
            connections.append(f".{name}({signal}[{low[way] + bits - 1}:{low[way]}])")
            low[way] += bits
    return f"""module scanned(input clk, input scan_in, input capture, output scan_out);
  reg [{n_in - 1}:0] in_q; reg [{n_out - 1}:0] out_q; wire [{n_out - 1}:0] out_d;
  always @(posedge clk) in_q <= {{in_q, scan_in}};
  always @(posedge clk) out_q <= capture ? out_d : {{out_q, in_q[{n_in - 1}]}};
  assign scan_out = out_q[{n_out - 1}];
  {top} core({", ".join(connections)});
endmodule
"""


def _bits(ports: dict[str, tuple[str, int]], way: str) -> int:
    """Bits of the inputs or outputs but clk."""
    return sum(bits for name, (own, bits) in ports.items() if own == way and name != "clk")


def run_passes(passes: Sequence[str], log: Path) -> None:
    """Run Yosys on a list of its commands in the folder of log; raises InputError when it fails."""
    script = log.with_suffix(".ys")
    script.write_text("\n".join(passes) + "\n")
    with log.open("w") as file:
        command = [sys.executable, "-c", RUNNER, script.name]
        done = subprocess.run(command, cwd=log.parent, stdout=file, stderr=subprocess.STDOUT, check=False)
    if done.returncode:
        message = next((line for line in reversed(log.read_text().splitlines()) if "ERROR" in line), "no message")
        raise InputError(f"yosys: {message.strip()}; see {log}")
