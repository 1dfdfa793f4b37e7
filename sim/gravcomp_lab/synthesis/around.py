"""Verilog of what stands around a top while it is placed: flip-flops at its ports, so that every path is between two.

They are no part of the top: what they take is to be subtracted from its cells.
"""

from collections.abc import Callable, Mapping

# Direction and width of ports by name.
Ports = Mapping[str, tuple[str, int]]
Wrapper = Callable[[str, Ports], str]
# The module that a Wrapper writes.
AROUND = "around"


def registered(top: str, ports: Ports) -> str:
    """A flip-flop at every port but clk, and a pin for each."""
    around = {name: port for name, port in ports.items() if name != "clk"}
    declared = [f"{way} [{bits - 1}:0] {name}" for name, (way, bits) in around.items()]
    signals = [f"  reg [{bits - 1}:0] {name}_q; wire [{bits - 1}:0] {name}_d;" for name, (_, bits) in around.items()]
    moves, connections = [], []
    for name, (way, _) in around.items():
        inside = "q" if way == "input" else "d"
        moves += [f"  always @(posedge clk) {name}_q <= {name}_d;"]
        moves += [f"  assign {name}_d = {name};" if way == "input" else f"  assign {name} = {name}_q;"]
        connections += [f".{name}({name}_{inside})"]
    head = f"module {AROUND}(input clk, {', '.join(declared)});"
    core = f"  {top} core(.clk(clk), {', '.join(connections)});"
    return "\n".join([head, *signals, *moves, core, "endmodule", ""])


def scanned(clocks: Mapping[str, tuple[str, ...]]) -> Wrapper:
    """Wrapper of a top with more bits at its ports than a part has pins: the ports of each clock on a scan chain, with
    a pin for what is shifted in, one for what comes out, and one that takes the outputs over.

    clocks: port of each clock, and how the names of its ports begin; () for all others. An input takes a flip-flop per
    bit, an output a LUT as well.
    """

    def wrapped(top: str, ports: Ports) -> str:
        pins, body, connections = ["input take"], [], []
        for clock in clocks:
            own = {name: port for name, port in ports.items() if _clock_of(name, clocks) == clock}
            ins = {name: bits for name, (way, bits) in own.items() if way == "input"}
            outs = {name: bits for name, (way, bits) in own.items() if way == "output"}
            pins += [f"input {clock}", f"input {clock}_in", f"output {clock}_out"]
            n_in, n_out = sum(ins.values()), sum(outs.values())
            body += [f"  wire [{n_out - 1}:0] {clock}_d;"]
            body += _chain(clock, f"{clock}_i", n_in, f"{clock}_in", "")
            body += _chain(clock, f"{clock}_o", n_out, f"{clock}_i[{n_in - 1}]", f"take ? {clock}_d : ")
            body += [f"  assign {clock}_out = {clock}_o[{n_out - 1}];"]
            connections += [f".{clock}({clock})", *_slices(ins, f"{clock}_i"), *_slices(outs, f"{clock}_d")]
        head = f"module {AROUND}({', '.join(pins)});"
        return "\n".join([head, *body, f"  {top} core({', '.join(connections)});", "endmodule", ""])

    return wrapped


def scan_cells(ports: Ports, clocks: Mapping[str, tuple[str, ...]]) -> tuple[int, int]:
    """LUTs and flip-flops of the scan chains of a top."""
    outs, ins = (
        sum(bits for name, (way, bits) in ports.items() if way == which and name not in clocks)
        for which in ("output", "input")
    )
    return outs, outs + ins


def _clock_of(port: str, clocks: Mapping[str, tuple[str, ...]]) -> str | None:
    """The clock of a port; None of a clock itself."""
    if port in clocks:
        return None
    named = [clock for clock, beginnings in clocks.items() if beginnings and port.startswith(beginnings)]
    return named[0] if named else next(clock for clock, beginnings in clocks.items() if not beginnings)


def _chain(clock: str, name: str, bits: int, first: str, taken: str) -> list[str]:
    return [
        f"  reg [{bits - 1}:0] {name};",
        f"  always @(posedge {clock}) {name} <= {taken}{{{name}[{bits - 2}:0], {first}}};",
    ]


def _slices(ports: Mapping[str, int], chain: str) -> list[str]:
    connections, low = [], 0
    for name, bits in ports.items():
        connections.append(f".{name}({chain}[{low + bits - 1}:{low}])")
        low += bits
    return connections
