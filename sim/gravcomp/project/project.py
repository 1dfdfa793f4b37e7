"""Writes a project folder. Paths in it are those of the repository, so that scripts and pages hold for both."""

import re
import shlex
import shutil
import sys
import tomllib
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from gravcomp.core.compensation import COMPENSATION_CSV
from gravcomp.core.component import COMPONENT_XML, component_text
from gravcomp.core.provenance import PROVENANCE_JSON
from gravcomp.core.vhdl.network_package import rom_files, write_rom
from gravcomp.errors import InputError
from gravcomp.files import new_folder, write_all_atomically
from gravcomp.network.weights import HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV
from gravcomp.robot.machine import ROBOT_TOML, load_machine
from gravcomp.robot.mechanism.draft import draft_toml
from gravcomp.robot.mechanism.source import sources
from gravcomp.shipped import SHIPPED, built_in, shipped
from gravcomp.twin.precision import Precision

MACHINE = "weights/mine"
_GENERATED = "rtl/generated"
_TRAINED = (HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV, COMPENSATION_CSV, PROVENANCE_JSON)
_OWN = ("Makefile", "README.md")


def machine_named(text: str) -> Path:
    """A machine folder, or by its name one that comes with gravcomp. Raises InputError."""
    if Path(text).is_dir():
        return Path(text)
    if text in built_in():
        return shipped("weights") / text
    names = ", ".join(built_in())
    raise InputError(f"--robot {text}: no such folder; give a machine folder, or a machine that is built in: {names}")


def write_project(folder: Path, source: Path) -> Precision | None:
    """Write a project folder for the machine of a machine folder: all of it, or nothing.

    Returns what the formats cost; None, and no ROM, of a machine without a network, which is to be trained there.
    Raises InputError when folder is not empty, when it cannot be written, and as load_machine and write_rom do.
    """
    machine = load_machine(source)
    is_trained = any((source / name).exists() for name in _TRAINED)
    if is_trained:
        rom_files(source)  # refuses by the names that the user knows
    with new_folder(folder) as draft:
        _write_tools(draft, machine.n_axes)
        write_all_atomically(machine.contents(draft / MACHINE / ROBOT_TOML))
        for name in filter(lambda name: (source / name).exists(), _TRAINED):
            shutil.copyfile(source / name, draft / MACHINE / name)
        return write_rom(draft / MACHINE, draft / _GENERATED) if is_trained else None


def write_drafted_project(folder: Path, file: Path, axes: Sequence[str]) -> list[str]:
    """Write a project folder for the robot of a URDF or MJCF; returns the keys of robot.toml that are to be filled in.

    axes: joints with a motor, where not all that can be. Raises InputError as write_project and draft_toml do.
    """
    text, files = draft_toml(file, axes), sources(file)
    with new_folder(folder) as draft:
        _write_tools(draft, len(tomllib.loads(text)["axis"]))
        machine = draft / MACHINE
        write_all_atomically({machine / ROBOT_TOML: text, **{machine / name: data for name, data in files.items()}})
    return list(dict.fromkeys(re.findall(r"^#\? (\w+)", text, re.M)))


def _write_tools(draft: Path, n_axes: int) -> None:
    """All of a project but the machine and its ROM."""
    for name in SHIPPED:
        _copy(shipped(name), draft / name)
    (draft / COMPONENT_XML).write_text(component_text(n_axes), encoding="utf-8")
    for name in _OWN:
        (draft / name).write_text(_own(name), encoding="utf-8")


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
