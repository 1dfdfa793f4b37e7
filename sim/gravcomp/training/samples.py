"""A machine whose statics are a CSV of poses and efforts, whatever [model] and [workspace] of its robot.toml say."""

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.robot.machine import ROBOT_TOML, Machine, parse_machine

_HEADER = re.compile(r"\s*\[+\s*([^\].\s]+)")


def machine_of_samples(folder: Path, samples: Path) -> Machine:
    """The axes and the drive of a machine folder with the efforts of a CSV: its robot.toml with [model] kind "table".

    Raises InputError naming file and key.
    """
    path = folder / ROBOT_TOML
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a machine folder") from error
    # Read from where the CSV is, written to where it will be: beside robot.toml.
    machine = parse_machine(_with_table(text, str(samples.absolute()), path), str(path))
    return replace(machine, text=_with_table(text, samples.name, path))


def _with_table(text: str, file: str, where: Path) -> str:
    kept, is_kept = [], True
    for line in text.splitlines():
        if header := _HEADER.match(line):
            is_kept = header[1].strip('"') not in ("model", "workspace")
        if is_kept:
            kept.append(line)
    model = f'[model]\nkind = "table"\nfile = {json.dumps(file)}'
    new = "\n".join([*kept, "", model, ""])
    try:
        before, after = tomllib.loads(text), tomllib.loads(new)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: not valid TOML ({error}); correct that line") from error
    if {**before, "model": None, "workspace": None} != {"workspace": None, **after, "model": None}:
        raise InputError(f"{where}: write [model] and [workspace] as tables of their own, to be replaced by --data")
    return new
