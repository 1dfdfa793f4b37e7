"""scripts/test_simulators.sh: runs what can be had on each simulator, says what cannot, and fails when a test fails."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from codes import ROOT

UNPACKED = "build/simulators/debian-13/usr/bin/ghdl-mcode", "build/simulators/debian-13/usr/lib64/ld-linux-x86-64.so.2"


def write_program(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


@pytest.fixture
def tree(tmp_path):
    """A tree whose Python, apt-get and simulators are stubs; apt-get fails."""
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    write_program(tmp_path / "bin/apt-get", 'echo "no network"; exit 1')
    write_program(tmp_path / ".venv/bin/python", 'ghdl "$@" && [ -z "$FAILS" ]')
    return tmp_path


def run(tree: Path, **environment: str) -> subprocess.CompletedProcess:
    path = f"{tree}/bin:/usr/sbin:/sbin:{tree}/tools"
    (tree / "tools").mkdir(exist_ok=True)
    for tool in ("sh", "dirname", "mkdir", "cat", "tail", "head", "sed", "tr", "chmod", "readlink", "ls", "id"):
        if not (tree / "tools" / tool).exists():
            (tree / "tools" / tool).symlink_to(shutil.which(tool))
    variables = {**os.environ, "PATH": path, "FAILS": "", **environment}
    return subprocess.run(
        [tree / "scripts/test_simulators.sh", "tests"], env=variables, capture_output=True, text=True, check=False
    )


def have_llvm(tree: Path) -> None:
    write_program(tree / "bin/ghdl-llvm", 'echo "llvm runs $*"')


def have_debian_13(tree: Path) -> None:
    """Unpacked already; its loader starts nothing but says what it would."""
    write_program(tree / UNPACKED[0], "exit 1")
    write_program(tree / UNPACKED[1], 'shift 2; shift; echo "debian 13 runs $*"')


def test_what_cannot_be_had_is_said_and_nothing_run_is_a_failure(tree):
    done = run(tree)
    assert done.returncode == 1
    assert "ghdl-5: NOT RUN, it cannot be had: " in done.stdout
    assert "ghdl-llvm: NOT RUN, it cannot be had: not installed" in done.stdout


def test_one_that_can_be_had_is_run_and_the_other_is_said(tree):
    have_llvm(tree)
    done = run(tree)
    assert done.returncode == 0
    assert "llvm runs -m pytest tests" in done.stdout
    assert "ghdl-llvm: passed" in done.stdout
    assert "ghdl-5: NOT RUN" in done.stdout


def test_both_run_with_their_own_ghdl(tree):
    have_llvm(tree)
    have_debian_13(tree)
    done = run(tree)
    assert done.returncode == 0
    assert "debian 13 runs -m pytest tests" in done.stdout
    assert "llvm runs -m pytest tests" in done.stdout
    assert done.stdout.count(": passed") == 2


def test_a_failing_test_fails(tree):
    have_llvm(tree)
    done = run(tree, FAILS="1")
    assert done.returncode == 1
    assert "ghdl-llvm: FAILED" in done.stdout
