"""The only caller of the simulators: runs cocotb tests of an entity, in rtl/ under GHDL or as Verilog under Icarus."""

import os
import re
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

from cocotb_tools.check_results import get_results
from cocotb_tools.runner import get_runner

ROOT = Path(__file__).resolve().parents[1]
# Elsewhere where a mutant of the VHDL is tried.
RTL = Path(os.environ.get("GRAVCOMP_RTL", ROOT / "rtl"))
GENERATED = RTL / "generated"
BUILD = Path(os.environ.get("GRAVCOMP_BUILD", ROOT / "build"))
BENCHES = ROOT / "tb" / "hdl"


def rtl_sources(generated: Path = GENERATED) -> list[Path]:
    """The files of rtl/sources.f in compile order; generated/ may be replaced by another network's."""
    names = (RTL / "sources.f").read_text().split()
    return [generated / Path(name).name if name.startswith("generated/") else RTL / name for name in names]


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
) -> None:
    """Run the cocotb tests of test_module (a module of tb/) on an entity; AssertionError when one fails or none runs.

    generics are set on the entity and handed to the test as environment variables of the same name in upper case.
    verilog: files to simulate in place of rtl/, under Icarus; generics are then those that the entity was made with.
    tests selects cocotb tests by regular expression; label tells apart builds that share entity and generics.
    """
    generics = dict(generics or {})
    name = "-".join([test_module, label, *(f"{k}{v}" for k, v in generics.items())])
    build_dir = BUILD / "tb" / re.sub(r"[^\w.-]", "_", name)
    build_dir.mkdir(parents=True, exist_ok=True)
    build_log, log = build_dir / "build.log", build_dir / "run.log"
    runner = get_runner("icarus" if verilog else "ghdl")
    try:
        runner.build(
            sources=verilog or [*rtl_sources(generated), *extra_sources],
            hdl_toplevel=entity,
            build_args=["-g2012"] if verilog else ["--std=08"],
            timescale=("1ns", "1ps") if verilog else None,
            build_dir=build_dir,
            always=True,
            log_file=build_log,
        )
    except RuntimeError as stop:
        raise AssertionError(f"{name}: does not compile ({stop})\n{_tail(build_log)}") from None
    try:
        variables = {
            "PYTHONPATH": os.pathsep.join([str(ROOT / "tb"), os.environ.get("PYTHONPATH", "")]),
            **{k.upper(): str(v) for k, v in generics.items()},
            **(environment or {}),
        }
        # In os.environ, because cocotb's runner prefers that to its own extra_env: make exports WEIGHTS.
        with patch.dict(os.environ, variables):
            results = runner.test(
                hdl_toplevel=entity,
                test_module=test_module,
                test_args=[] if verilog else ["--std=08"],
                parameters={} if verilog else generics,
                plusargs=[f"--vcd={vcd}"] if vcd else [],
                build_dir=build_dir,
                test_filter=tests,
                log_file=log,
            )
        n_tests, n_failed = get_results(results)
    except (SystemExit, RuntimeError) as stop:
        raise AssertionError(f"{name}: the simulation failed ({stop})\n{_tail(log)}") from None
    assert n_tests > 0, f"{name}: no cocotb test ran\n{_tail(log)}"
    assert n_failed == 0, f"{name}: {n_failed} of {n_tests} cocotb tests failed\n{_tail(log)}"


def verilate(verilog: Sequence[Path], entity: str, bench: Path, name: str) -> Path:
    """Compile an entity's Verilog and a bench in C++ with Verilator; returns the program. AssertionError on failure."""
    folder = BUILD / "verilated" / name
    folder.mkdir(parents=True, exist_ok=True)
    command = ["verilator", "--cc", "--exe", "--build", "-O3", "-CFLAGS", "-O2", "--top-module", entity]
    command += ["-Wno-lint", "-Wno-INITIALDLY", "-Wno-UNOPTFLAT", "--Mdir", folder, "-o", "bench", *verilog, bench]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{name}: Verilator fails\n{done.stderr[-3000:]}"
    return folder / "bench"


def _tail(log: Path, lines: int = 60) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-lines:]) if log.exists() else "(no log)"
