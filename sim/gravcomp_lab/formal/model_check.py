"""Unbounded proof of a checker's assertions: Yosys to an and-inverter graph, ABC's property-directed reachability.

PDR ends with an inductive invariant (it holds at power-up, each clock preserves it, it implies the assertion), which
ABC verifies once more, or with a run that breaks the assertion. Inputs, and registers without an initial value, are
free in every clock. Logic that no assertion depends on drops out: a proof about valid bits never sees a multiplier.

Source: N. Een, A. Mishchenko, R. Brayton, "Efficient implementation of property directed reachability", FMCAD 2011.
"""

import json
import re
import subprocess
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.synthesis.yosys import run_passes

# Products are cut, and inputs that a checker leaves open are free: any value may stand for one, in every clock. What
# holds for all values holds for the right one. cuts: more signals to cut, as ` w:path`. clocks: how a clock becomes one
# of the graph's, _ONE_CLOCK or _FREE_CLOCKS. What aigmap leaves over is not written, and takes long to clean away.
_TO_GRAPH = (
    "proc -latches error; flatten; setundef -undriven -anyseq; cutpoint t:$mul{cuts}; {clocks}; chformal -lower; "
    "opt_clean; memory -nomap; memory_map; opt -full; dffunmap; formalff -clk2ff; setundef -undriven -anyseq; "
    "delete -output; opt -full; techmap; opt_clean; aigmap"
)
# Every clock of the design is the graph's, and a step of the graph a clock.
_ONE_CLOCK = "async2sync"
# Clocks are inputs: a step of the graph may raise any of them, or none.
_FREE_CLOCKS = "clk2fflogic"
_ASSERTED = r"was (?:trivially )?asserted in frame +(\d+)"
# Most runs that break an assertion are short; a search that unrolls finds them in less time than one that proves.
_SHORT_RUN, _SHORT_RUN_S = 40, 30


@dataclass(frozen=True)
class Verdict:
    """What became of a checker's assertions.

    proven: names of those that hold for ever. broken: those that do not, each with the clocks of a run from power-up
    that breaks it. open: without verdict in the time given.
    """

    proven: tuple[str, ...]
    broken: Mapping[str, int]
    open: tuple[str, ...]

    @property
    def holds(self) -> bool:
        return bool(self.proven) and not self.broken and not self.open


def model_check(
    verilog: Path,
    checker: Path,
    out: Path,
    parameters: Mapping[str, int | str] | None = None,
    correspondence_clocks: int = 1,
    timeout_s: int = 300,
    *,
    free_clocks: bool = False,
    cuts: Sequence[str] = (),
    rewrite: bool = False,
) -> Verdict:
    """Prove or refute the assertions of a checker (a SystemVerilog module named as its file) that holds the design.

    A checker reaches a signal inside the design by a wire of the same path: (* hierconn *) wire \\dut.name .
    Equal signals are merged before, by induction over correspondence_clocks: one per step of a counter brings counters
    in agreement together. out: folder for intermediate files. free_clocks: clocks are inputs, whose edges fall in any
    order; else every clock is the same one. cuts: signals of the design, by path, that may have any value in every
    clock. rewrite: the graph's logic is made smaller before, and clauses are generalised with more effort, which finds
    some invariants in a tenth of the time and others not at all. Raises InputError when Yosys or ABC fails.
    """
    out.mkdir(parents=True, exist_ok=True)
    graph = out / "graph.aig"
    names = _write_graph(verilog, checker, dict(parameters or {}), graph, free_clocks, cuts)
    merge = "scorr" if correspondence_clocks == 1 else f"scorr; scorr -F {correspondence_clocks}"
    search = "dc2; pdr -n -a" if rewrite else "pdr -a"
    log = _abc(f"read_aiger {graph}; fold; strash; {merge}; {search} -T {timeout_s}", out / "pdr.log")
    if "Properties:" not in log:
        raise InputError(f"{checker.stem}: ABC gave no verdict; see {out / 'pdr.log'}")
    proven = {int(k) for k in re.findall(r"Proved output +(\d+)", log)}
    broken = _broken(names, log)
    return Verdict(
        tuple(name for k, name in enumerate(names) if k in proven),
        broken,
        tuple(name for k, name in enumerate(names) if k not in proven and name not in broken),
    )


def induct(
    verilog: Path,
    checker: Path,
    out: Path,
    parameters: Mapping[str, int | str] | None = None,
    clocks: int = 1,
    cuts: Sequence[str] = (),
) -> Verdict:
    """Prove a checker whose assertions together are inductive as they stand: after some clocks that kept all of them,
    from whatever state, the next one does, and the first ones from power-up do.

    For assertions about arithmetic and wide words, where PDR is lost. clocks: 1 where the assertions say all that there
    is to say about registers, or the length of a pipeline. Other arguments and errors as of model_check.
    """
    out.mkdir(parents=True, exist_ok=True)
    graph = out / "graph.aig"
    names = _write_graph(verilog, checker, dict(parameters or {}), graph, cuts=cuts)
    read = f"read_aiger {graph}; fold; strash"
    step = _abc(f"{read}; orpos; ind -F {clocks + 1}", out / "ind.log")
    if "Networks are equivalent" in step:
        # The step assumes the clocks before: power-up is checked for those.
        log = _abc(f"{read}; bmc3 -F {clocks + 1} -T 60", out / "bmc.log")
        if "No output asserted" in log:
            return Verdict(tuple(names), {}, ())
    broken = {}
    for k, name in enumerate(names):
        # Each by itself: ABC dies of some graphs when it shall break several in one run.
        log = _abc(f"{read}; cone -O {k}; bmc3 -F {clocks + 11} -T 10", out / "bmc.log")
        if found := re.search(_ASSERTED, log):
            broken[name] = int(found[1]) + 1
    return Verdict((), broken, tuple(name for name in names if name not in broken))


def refute(
    verilog: Path,
    checker: Path,
    out: Path,
    parameters: Mapping[str, int | str],
    assertions: Collection[str],
    timeout_s: int = 300,
    *,
    free_clocks: bool = False,
    cuts: Sequence[str] = (),
) -> Verdict:
    """Look for runs that break these assertions, each by itself, as of model_check; nothing is said about the others,
    which a broken design may leave without a verdict for long.
    """
    out.mkdir(parents=True, exist_ok=True)
    graph, broken = out / "graph.aig", {}
    names = _write_graph(verilog, checker, dict(parameters), graph, free_clocks, cuts)
    for k in (k for k, name in enumerate(names) if name in assertions):
        read = f"read_aiger {graph}; fold; strash; cone -O {k}"
        log = _abc(f"{read}; bmc3 -F {_SHORT_RUN} -T {_SHORT_RUN_S}", out / f"bmc-{k}.log")
        if not (found := re.search(_ASSERTED, log)):
            log = _abc(f"{read}; scorr; pdr -a -T {timeout_s}", out / f"pdr-{k}.log")
            found = re.search(_ASSERTED, log)
        if found:
            broken[names[k]] = int(found[1]) + 1
    return Verdict((), broken, tuple(name for name in names if name in assertions and name not in broken))


def _broken(names: Sequence[str], log: str) -> dict[str, int]:
    """Assertions that ABC's PDR broke, each with the clocks of the run that breaks it."""
    found = re.findall(r"Output +(\d+) was (?:trivially )?asserted in frame +(\d+)", log)
    return {names[int(k)]: int(frame) + 1 for k, frame in found}


def shortest_run(verilog: Path, checker: Path, out: Path, parameters: Mapping[str, int | str]) -> int:
    """Clocks of the shortest run from power-up that breaks the only assertion of a checker; arguments of model_check.

    Raises InputError when there is none of less than a thousand clocks.
    """
    out.mkdir(parents=True, exist_ok=True)
    graph = out / "graph.aig"
    _write_graph(verilog, checker, dict(parameters), graph)
    log = _abc(f"read_aiger {graph}; fold; strash; bmc3 -F 1000", out / "bmc.log")
    if not (found := re.search(r"was asserted in frame +(\d+)", log)):
        raise InputError(f"{checker.stem}: no run of 1000 clocks breaks it; see {out / 'bmc.log'}")
    return int(found[1]) + 1


def write_miter(
    gold: Path, gate: Path, top: str, out: Path, *, from_zero: bool = False, timeout_s: float | None = None
) -> Path:
    """The graph in which an output tells that a port of a module differs between two Verilog files, run from power-up
    on the same inputs; for differs_soon and same_at_ports. Raises InputError when Yosys fails, or takes longer.

    from_zero: registers without a value at power-up begin with 0; otherwise with any, in each of the two.
    """
    graph, passes = out / "miter.aig", []
    start = ["setundef -undriven -zero", "setundef -init -zero"] if from_zero else []
    for name, verilog in (("gold", gold), ("gate", gate)):
        passes += [f"read_verilog {verilog.resolve()}", f"hierarchy -check -top {top}", "proc -latches error"]
        passes += ["flatten", "opt_clean", *start, f"rename {top} {name}", f"design -stash {name}"]
    passes += [f"design -copy-from {name} {name}" for name in ("gold", "gate")]
    passes += ["miter -equiv -flatten -make_assert gold gate miter", "hierarchy -top miter"]
    passes += _TO_GRAPH.format(cuts="", clocks=_ONE_CLOCK).split("; ")
    passes += [f"write_aiger -I -B -zinit -no-startoffset {graph.name}"]
    run_passes(passes, graph.with_suffix(".log"), timeout_s)
    return graph


def differs_soon(miter: Path, timeout_s: int) -> bool:
    """Whether a short run is found in which a port differs."""
    log = _abc(f"read_aiger {miter}; fold; strash; bmc3 -F {_SHORT_RUN} -T {timeout_s}", miter.with_suffix(".bmc"))
    return re.search(_ASSERTED, log) is not None


def same_at_ports(miter: Path, timeout_s: int) -> bool:
    """Whether no port ever differs, proven in the time given. Registers may, which no matching of names allows."""
    log = _abc(f"read_aiger {miter}; fold; strash; scorr; pdr -a -T {timeout_s}", miter.with_suffix(".pdr"))
    return "Proved output" in log or "Property proved" in log


def _write_graph(
    verilog: Path,
    checker: Path,
    parameters: dict[str, int | str],
    graph: Path,
    free_clocks: bool = False,
    cuts: Sequence[str] = (),
) -> list[str]:
    """Write the graph of a checker and its design; returns the names of its assertions, one per output."""
    values = " ".join(f"-chparam {name} {value}" for name, value in parameters.items())
    names = graph.with_suffix(".json")
    cut = "".join(f" w:dut.{path}" for path in cuts)
    to_graph = _TO_GRAPH.format(cuts=cut, clocks=_FREE_CLOCKS if free_clocks else _ONE_CLOCK)
    passes = [
        f"read_verilog -formal -sv {verilog.resolve()} {checker.resolve()}",
        f"hierarchy -check -top {checker.stem} {values}",
        *to_graph.split("; "),
        f"write_aiger -I -B -zinit -no-startoffset -ywmap {names.name} {graph.name}",
    ]
    run_passes(passes, graph.with_suffix(".log"))
    return [path[-1].split("$")[0].lstrip("\\") for path in json.loads(names.read_text())["asserts"]]


def _abc(script: str, log: Path) -> str:
    import pyosys  # loads Yosys, which takes a second

    with log.open("w") as file:
        command = [Path(pyosys.__file__).with_name("yosys-abc"), "-c", script]
        subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False)
    return log.read_text(errors="replace")
