"""Where the files of this tree are, and simulations of them: gravcomp.simulation with the defaults of the tests."""

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from gravcomp.simulation import simulator
from gravcomp_lab.synthesis import verilog as synthesis

ROOT = Path(__file__).resolve().parents[1]
# Elsewhere where a mutant of the VHDL is tried.
RTL = Path(os.environ.get("GRAVCOMP_RTL", ROOT / "rtl"))
GENERATED = RTL / "generated"
BUILD = Path(os.environ.get("GRAVCOMP_BUILD", ROOT / "build"))
BENCHES = ROOT / "tb" / "hdl"


def rtl_sources(generated: Path = GENERATED) -> list[Path]:
    """The files of rtl/sources.f in compile order; generated/ may be replaced by another network's."""
    return synthesis.rtl_sources(RTL, generated)


def simulate(
    entity: str,
    test_module: str,
    *,
    generics: Mapping[str, int] | None = None,
    environment: Mapping[str, str] | None = None,
    generated: Path = GENERATED,
    extra_sources: tuple[Path, ...] = (),
    verilog: Sequence[Path] = (),
    tests: str | None = None,
    label: str = "",
    vcd: Path | None = None,
) -> dict:
    """Run the cocotb tests of test_module (a module of tb/) on an entity of rtl/; AssertionError when one fails.

    verilog: files to simulate in place of rtl/. label tells apart builds that share entity and generics. The rest is
    that of ``simulator.simulate``.
    """
    name = "-".join([test_module, label, *(f"{k}{v}" for k, v in (generics or {}).items())])
    return simulator.simulate(
        entity,
        test_module,
        sources=verilog or [*rtl_sources(generated), *extra_sources],
        build_dir=BUILD / "tb" / re.sub(r"[^\w.-]", "_", name),
        generics=generics,
        environment=environment,
        is_verilog=bool(verilog),
        tests=tests,
        vcd=vcd,
    )


def verilate(verilog: Sequence[Path], entity: str, bench: Path, name: str) -> Path:
    """``simulator.verilate`` in the folder of a name."""
    return simulator.verilate(verilog, entity, bench, BUILD / "verilated" / name)
