"""Statement coverage of the VHDL: GHDL's GCC back end counts, gcov and gcovr sum up over all simulations."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.mutation.trial import LEFT_OUT
from gravcomp_lab.synthesis.verilog import handwritten_sources

# cocotb calls `ghdl -m` to compile; only that takes options for GCC.
_GHDL = """#!/bin/sh
if [ "$1" = -m ]; then
    shift
    set -- -m -Wc,-fprofile-arcs -Wc,-ftest-coverage -Wl,-lgcov "$@"
fi
exec ghdl-gcc "$@"
"""


@dataclass(frozen=True)
class Coverage:
    """Of one VHDL file: its statements, and those that never ran (line number, text)."""

    file: str
    n_lines: int
    missed: tuple[tuple[int, str], ...]


def count(root: Path, build: Path, jobs: int) -> list[Coverage]:
    """Simulate the tests of tb/ with counters; coverage of each file of rtl/ but the generated ones.

    Raises InputError when GHDL's GCC back end is missing, or a test fails.
    """
    if not shutil.which("ghdl-gcc"):
        raise InputError("ghdl-gcc: not found; start `make coverage`, which installs it")
    shutil.rmtree(build, ignore_errors=True)
    wrapper = build / "bin" / "ghdl"
    wrapper.parent.mkdir(parents=True)
    wrapper.write_text(_GHDL)
    wrapper.chmod(0o755)
    files = [str(path) for path in sorted((root / "tb").glob("test_rtl_*.py")) if path.name not in LEFT_OUT]
    environment = {**os.environ, "GRAVCOMP_BUILD": str(build), "PATH": f"{wrapper.parent}:{os.environ['PATH']}"}
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), *files]
    if subprocess.run(command, cwd=root, env=environment, check=False).returncode:
        raise InputError("a test fails; a coverage without it would not be the tests' coverage")
    return _sum_up(root / "rtl", build)


def _sum_up(rtl: Path, build: Path) -> list[Coverage]:
    # Elaboration, benches and generated packages: their sources are elsewhere, or gone.
    sources = handwritten_sources(rtl)
    for counts in [*build.rglob("*.gcno"), *build.rglob("*.gcda")]:
        if counts.stem not in sources:
            counts.unlink()
    report = build / "coverage.json"
    command = [
        Path(sys.executable).with_name("gcovr"),
        "--root",
        rtl,
        "--filter",
        f"{rtl}/(.*/)?gc_",
        "--json",
        report,
        build,
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"gcovr: {done.stderr.strip().splitlines()[-1]}")
    return [_of_file(rtl, entry) for entry in json.loads(report.read_text())["files"]]


def _of_file(rtl: Path, entry: dict) -> Coverage:
    text = (rtl / entry["file"]).read_text().split("\n")
    ran: dict[int, bool] = {}
    for line in entry["lines"]:
        ran[line["line_number"]] = ran.get(line["line_number"], False) or line["count"] > 0
    missed = tuple((number, text[number - 1].strip()) for number, is_run in sorted(ran.items()) if not is_run)
    return Coverage(Path(entry["file"]).name, len(ran), missed)


def reasons(path: Path) -> dict[tuple[str, str], str]:
    """Why a statement never runs: (file, line) -> reason, from a TOML file."""
    return {(entry["file"], entry["line"]): entry["reason"] for entry in tomllib.loads(path.read_text())["uncovered"]}


def markdown(coverages: list[Coverage], why: dict[tuple[str, str], str]) -> str:
    """Two tables: coverage by file, and every statement that never ran with its reason."""
    n_all, n_missed = sum(c.n_lines for c in coverages), sum(len(c.missed) for c in coverages)
    rows = [(c.file, c.n_lines, len(c.missed)) for c in coverages] + [("all", n_all, n_missed)]
    lines = [
        "# Statement coverage of the VHDL",
        "",
        "Written by `make coverage` from the simulations of `tb/test_rtl_*.py`.",
        "",
    ]
    lines += ["| file | statements | never run | coverage |", "|---|---|---|---|"]
    lines += [f"| {file} | {n} | {missed} | {100 * (1 - missed / n):.1f} % |" for file, n, missed in rows]
    if n_missed:
        lines += ["", "| never run | statement | why |", "|---|---|---|"]
    for c in coverages:
        for number, text in c.missed:
            lines += [f"| {c.file}:{number} | `{text}` | {why.get((c.file, text), '**not explained**')} |"]
    return "\n".join(lines) + "\n"
