"""Verilator, which makes programs and libraries of Verilog."""

import subprocess
from collections.abc import Sequence
from pathlib import Path

from gravcomp.errors import InputError


def run_verilator(arguments: Sequence[str | Path]) -> None:
    """Run it with these arguments; InputError when it is missing or refuses."""
    try:
        done = subprocess.run(["verilator", *arguments], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise InputError("verilator: not found; start `scripts/setup.sh verilator`") from None
    if done.returncode:
        raise InputError(f"verilator: {(done.stderr.strip() or done.stdout.strip())[-2000:]}")
