"""Simulates a bench of this package: the lab's only caller of gravcomp.simulation for benches."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from gravcomp.simulation.simulator import simulate
from gravcomp_lab.synthesis.verilog import rtl_sources


def run_bench(
    entity: str,
    module: str,
    lanes: int,
    rtl: Path,
    build_dir: Path,
    environment: Mapping[str, str],
    sources: Sequence[Path] = (),
    tests: str | None = None,
    vcd: Path | None = None,
    generated: Path | None = None,
) -> dict:
    """What the cocotb tests of a module handed over, run under GHDL on an entity of rtl with so many lanes.

    sources: VHDL of the bench, behind that of rtl. generated: as of ``rtl_sources``. The rest, and errors, as of
    ``simulate``.
    """
    return simulate(
        entity,
        module,
        sources=[*rtl_sources(rtl, generated), *sources],
        build_dir=build_dir,
        generics={"lanes_g": lanes},
        environment=environment,
        tests=tests,
        vcd=vcd,
    )
