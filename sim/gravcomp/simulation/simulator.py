"""Runs cocotb tests of an entity, in VHDL under GHDL or as Verilog under Icarus; compiles benches with Verilator."""

import importlib.util
import os
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

from gravcomp.errors import optional
from gravcomp.simulation.measured import FILE, handed_over
from gravcomp.simulation.quick_ieee import quick_ieee


def simulate(
    entity: str,
    test_module: str,
    *,
    sources: Sequence[Path],
    build_dir: Path,
    generics: Mapping[str, int] | None = None,
    environment: Mapping[str, str] | None = None,
    is_verilog: bool = False,
    tests: str | None = None,
    vcd: Path | None = None,
) -> dict:
    """Run the cocotb tests of test_module on an entity; AssertionError when one fails or none runs.

    sources: VHDL in compile order, under GHDL; with is_verilog Verilog, under Icarus, made with the generics. generics
    are set on the entity and handed to the test as environment variables of the same name in upper case. tests selects
    cocotb tests by regular expression. Returns what they handed over (gravcomp.simulation.measured), by name.
    """
    get_runner = optional("cocotb_tools.runner", "cocotb", "a simulation").get_runner
    generics = dict(generics or {})
    build_dir.mkdir(parents=True, exist_ok=True)
    handed = build_dir.absolute() / "measured.json"
    handed.unlink(missing_ok=True)
    variables = {
        **{k.upper(): str(v) for k, v in generics.items()},
        **(environment or {}),
        # Of all modules that are imported, as cocotb's default has it, it takes several seconds of each simulation.
        "COCOTB_REWRITE_ASSERTION_FILES": shlex.quote(str(_folder_of(test_module) / "*.py")),
        FILE: str(handed),
    }
    runner = get_runner("icarus" if is_verilog else "ghdl")
    options = ["-g2012"] if is_verilog else ["--std=08", *quick_ieee(build_dir.parent)]
    _build(runner, build_dir, is_verilog, build_args=options, sources=sources, hdl_toplevel=entity)
    _test(
        runner,
        build_dir,
        variables,
        hdl_toplevel=entity,
        test_module=test_module,
        test_args=[] if is_verilog else options,
        parameters={} if is_verilog else generics,
        plusargs=[f"--vcd={vcd}"] if vcd else [],
        test_filter=tests,
    )
    return handed_over(handed)


def _build(runner, build_dir: Path, is_verilog: bool, **options) -> None:
    """Compile; AssertionError, with the end of what the simulator said, when that fails."""
    log = build_dir / "build.log"
    try:
        runner.build(
            timescale=("1ns", "1ps") if is_verilog else None,
            build_dir=build_dir,
            always=True,
            log_file=log,
            **options,
        )
    except RuntimeError as stop:
        raise AssertionError(f"{build_dir.name}: does not compile ({stop})\n{_tail(log)}") from None


def _test(runner, build_dir: Path, variables: Mapping[str, str], **options) -> None:
    """Simulate; AssertionError, with the end of the log, when a cocotb test fails or none ran."""
    from cocotb_tools.check_results import get_results

    name, log = build_dir.name, build_dir / "run.log"
    try:
        # In os.environ, because cocotb's runner prefers that to its own extra_env: make exports WEIGHTS.
        with patch.dict(os.environ, variables):
            results = runner.test(build_dir=build_dir, log_file=log, **options)
        n_tests, n_failed = get_results(results)
    except (SystemExit, RuntimeError) as stop:
        raise AssertionError(f"{name}: the simulation failed ({stop})\n{_tail(log)}") from None
    assert n_tests > 0, f"{name}: no cocotb test ran\n{_tail(log)}"
    assert n_failed == 0, f"{name}: {n_failed} of {n_tests} cocotb tests failed\n{_tail(log)}"


def _folder_of(module: str) -> Path:
    spec = importlib.util.find_spec(module)
    assert spec, f"{module}: no such module on the path"
    return Path(spec.origin).parent


def compiler_effort(level: int) -> tuple[str, str]:
    """Options of Verilator for the C++ compiler's level of optimisation, 0 to 3, of what runs in every clock.

    In -CFLAGS a level has no effect: Verilator's makefile adds its own, -Os, behind them. It takes three times as long
    to compile as level 1, and the program runs half as fast.
    """
    return "-MAKEFLAGS", f"OPT_FAST=-O{level} OPT_GLOBAL=-O{level} OPT_SLOW=-O0"


def verilate(verilog: Sequence[Path], entity: str, bench: Path, folder: Path) -> Path:
    """Compile an entity's Verilog and a bench in C++ with Verilator in a folder; returns the program. AssertionError
    when that fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    command = ["verilator", "--cc", "--exe", "--build", "-O3", *compiler_effort(1), "--top-module", entity]
    command += ["-Wno-lint", "-Wno-INITIALDLY", "-Wno-UNOPTFLAT", "--Mdir", folder, "-o", "bench", *verilog, bench]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{folder.name}: Verilator fails\n{done.stderr[-3000:]}"
    return folder / "bench"


def _tail(log: Path, lines: int = 60) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-lines:]) if log.exists() else "(no log)"
