"""Writes a project folder. Paths in it are those of the repository, so that scripts and pages hold for both."""

import shlex
import shutil
import sys
from importlib.resources import files
from pathlib import Path

from gravcomp.core.compensation import COMPENSATION_CSV
from gravcomp.core.provenance import PROVENANCE_JSON
from gravcomp.core.vhdl.network_package import rom_files, write_rom
from gravcomp.errors import InputError
from gravcomp.files import new_folder
from gravcomp.network.weights import HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV
from gravcomp.robot.machine import ROBOT_TOML
from gravcomp.shipped import SHIPPED, shipped

MACHINE = "weights/mine"
_GENERATED = "rtl/generated"
_MACHINE_FILES = (ROBOT_TOML, HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV, COMPENSATION_CSV, PROVENANCE_JSON)
_OWN = ("Makefile", "README.md")


def machine_named(text: str) -> Path:
    """A machine folder, or by its name one that comes with gravcomp. Raises InputError."""
    named = shipped("weights") / text
    if Path(text).is_dir():
        return Path(text)
    if Path(text).name == text and named.is_dir():
        return named
    names = ", ".join(sorted(path.name for path in shipped("weights").iterdir() if path.is_dir()))
    raise InputError(f"--robot {text}: no such folder; give a machine folder, or a machine that is built in: {names}")


def write_project(folder: Path, machine: Path):
    """Write a project folder for the machine of a machine folder: all of it, or nothing; returns the formats' cost.

    Raises InputError when folder is not empty, when it cannot be written, and as write_rom does.
    """
    rom_files(machine)  # refuses by the names that the user knows
    with new_folder(folder) as draft:
        for name in SHIPPED:
            _copy(shipped(name), draft / name)
        for name in _OWN:
            (draft / name).write_text(_own(name), encoding="utf-8")
        (draft / MACHINE).mkdir(parents=True)
        for name in _MACHINE_FILES:
            if (machine / name).exists():
                shutil.copyfile(machine / name, draft / MACHINE / name)
        return write_rom(draft / MACHINE, draft / _GENERATED)


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        shutil.copytree(source, target, ignore=shutil.ignore_patterns(Path(_GENERATED).name))
    else:
        shutil.copyfile(source, target)


def _own(name: str) -> str:
    """A file that is no copy; the Makefile knows where gravcomp is when no PATH leads to it."""
    text = files(__package__).joinpath(name).read_text(encoding="utf-8")
    return text.replace("@PYTHON@", shlex.quote(sys.executable).replace("$", "$$"))
