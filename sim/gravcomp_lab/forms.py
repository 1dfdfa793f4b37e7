"""A machine folder in another form of its network, for what the project measures of both."""

import shutil
from pathlib import Path

from gravcomp.files import write_atomically
from gravcomp.robot.machine import ROBOT_TOML, load_machine


def form_copy(weights: Path, build: Path, form: str) -> Path:
    """A copy of a machine folder in build, its network in a form of gravcomp.robot.machine.FORMS."""
    folder = build / form / weights.name
    shutil.copytree(weights, folder, dirs_exist_ok=True)
    write_atomically(folder / ROBOT_TOML, load_machine(weights).with_form(form).text)
    return folder
