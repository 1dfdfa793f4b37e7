"""Every register of an entity, for a test to write a wrong bit to: as Verilog under Icarus, where it stays written."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gravcomp_lab.inject.state import find_state
from gravcomp_lab.synthesis.verilog import to_verilog
from runner import BUILD, rtl_sources, simulate


@dataclass(frozen=True)
class Register:
    """A register under simulation: its entity, what the VHDL calls it, its width."""

    entity: str
    name: str
    bits: int
    handle: object

    def flip(self, bit: int) -> None:
        """Invert a bit, till the design writes it again."""
        self.handle.value = int(self.handle.value) ^ 1 << bit

    def __str__(self) -> str:
        return f"{self.handle._path} ({self.name})"


def registers(dut) -> list[Register]:
    """All of the entity under test, instance by instance. Those without a value at power-up get zeros."""
    verilog = Path(os.environ["FLIPS_VERILOG"])
    found = []
    for store in find_state(verilog.read_text(), verilog.stem, [path.stem for path in rtl_sources()]):
        handle = dut
        for name in (*store.path[1:], store.variable):
            handle = getattr(handle, name)
        if not handle.value.is_resolvable:
            handle.value = 0
        found.append(Register(store.entity, store.name, store.bits, handle))
    return found


def simulate_flips(entity: str, module: str, generics: Mapping[str, int | str], tests: str, **environment: str) -> None:
    """Run cocotb tests of a module of tb/ that flip registers of an entity."""
    verilog = to_verilog(rtl_sources(), entity, generics, BUILD / "flips" / f"{entity}.v")
    environment["FLIPS_VERILOG"] = str(verilog)
    simulate(entity, module, label=entity, generics=generics, verilog=[verilog], tests=tests, environment=environment)
