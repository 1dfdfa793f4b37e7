"""Another file in the place of a machine's own."""

import tempfile
from pathlib import Path

import numpy as np

from gravcomp.robot.machine import Machine, parse_machine
from gravcomp.robot.mechanism.robot import Mechanism


def reread(machine: Machine, text: str, gravity_mps2: np.ndarray | None = None) -> Mechanism:
    """The robot of a machine whose URDF or MJCF has the content text, and gravity (3,) where it is given.

    Raises InputError.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, content in machine.files.items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        (Path(folder) / machine.table["model"]["file"]).write_text(text, encoding="utf-8")
        robot = parse_machine(machine.text, str(Path(folder) / "robot.toml")).robot
    return robot if gravity_mps2 is None else robot.with_gravity(gravity_mps2 / np.linalg.norm(gravity_mps2))
