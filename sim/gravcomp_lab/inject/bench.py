"""gc_system as a program: GHDL's Verilog under Verilator with a bench in C++, driven through pipes."""

import subprocess
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.simulation.simulator import compiler_effort
from gravcomp_lab.inject.state import Store, find_state, make_public
from gravcomp_lab.synthesis.verilator import run_verilator
from gravcomp_lab.synthesis.verilog import to_verilog

TOP = "gc_system"


@dataclass(frozen=True)
class Design:
    """A compiled bench and the state in it, in the order of its numbers."""

    program: Path
    stores: list[Store]


def build(sources: Sequence[Path], generics: dict[str, int], bench: Path, folder: Path) -> Design:
    """Compile gc_system of these VHDL files and a bench into folder. InputError when a tool refuses."""
    folder.mkdir(parents=True, exist_ok=True)
    raw = to_verilog(sources, TOP, generics, folder / f"{TOP}-plain.v").read_text()
    stores = find_state(raw, TOP, [path.stem for path in sources])
    verilog = folder / f"{TOP}.v"
    write_atomically(verilog, make_public(raw))
    write_atomically(folder / "stores.h", _table(stores))
    flags = f"-std=c++20 -I{folder.resolve()}"
    options = [
        "--cc",
        "--exe",
        "--build",
        "-j",
        "2",
        "-O3",
        "--flatten",
        "--output-split",
        "20000",
        "--output-split-cfuncs",
        "2000",
        "--x-initial",
        "0",
        "-CFLAGS",
        flags,
        *compiler_effort(1),
    ]
    options += ["-Wno-lint", "-Wno-INITIALDLY", "-Wno-UNOPTFLAT", "--top-module", TOP, "--Mdir", folder / "verilated"]
    run_verilator([*options, "-o", "bench", verilog, bench.resolve()])
    return Design(folder / "verilated" / "bench", stores)


def _table(stores: Iterable[Store]) -> str:
    instances: dict[str, int] = {}
    lines = []
    for store in stores:
        instance = instances.setdefault(store.instance, len(instances))
        member = store.member(store.variable)
        depth = f"{store.depth}, " if store.depth else ""
        lines.append(f"{'MEMORY' if store.depth else 'REGISTER'}({member}, {store.bits}, {depth}{instance})")
        lines += [f"ADDRESS({store.member(address)})" for address in store.addresses]
    return "\n".join(lines) + "\n"


class Session:
    """A running bench: a bus for the driver, and what it is told. The bench ends with it."""

    def __init__(self, design: Design):
        self.n_stores = len(design.stores)
        pipe = subprocess.PIPE
        self._process = subprocess.Popen([design.program.resolve()], stdin=pipe, stdout=pipe, text=True)
        self.tell("n")

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()

    def tell(self, *order: object) -> None:
        """Give an order that has no answer."""
        self._process.stdin.write(" ".join(map(str, order)) + "\n")

    def ask(self, *order: object) -> str:
        """Give an order; its answer."""
        self.tell(*order)
        return self.answer()

    def answer(self) -> str:
        """The next line. InputError when the bench has ended."""
        self._process.stdin.flush()
        if line := self._process.stdout.readline():
            return line.strip()
        raise InputError(f"bench: ended with status {self._process.wait()}")

    def read(self, offset: int) -> int:
        """A register as the host reads it. InputError when the bus answers with an error or not at all."""
        answer = self.ask("r", offset)
        if answer == "ERROR":
            raise InputError(f"bench: reading {offset:#x} failed")
        return int(answer)

    def write(self, offset: int, word: int) -> None:
        """Write a register as the host does. InputError as for read."""
        if self.ask("w", offset, word) != "OK":
            raise InputError(f"bench: writing {offset:#x} failed")
