"""No command reads a robot but that of its weights or of --robot: every file that each of them opens is looked at."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from codes import ROOT
from gravcomp.cli import COMMANDS
from gravcomp.core.compensation import no_compensation, save_compensation
from gravcomp.driver.host import machine_settings
from gravcomp.robot.machine import ROBOT_TOML, load_machine
from machines import SHIPPED, changed, machine_folder
from measured_samples import holds, write_log
from onnx_files import torch_like
from support.model_board import ModelBoard
from support.model_mover import WholeModel
from test_py_board import LIMITS
from test_py_moving import MOTION, mover

# What the tree has of a machine.
OTHERS = (ROOT / "weights", ROOT / "rtl" / "generated", ROOT / "data")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A working folder outside the tree: machine/ differs from the shipped one by its motors, log.csv is of it."""
    folder = tmp_path_factory.mktemp("elsewhere")
    machine_folder(folder / "machine", text=changed(("effort_per_ampere = 45.0", "effort_per_ampere = 20.0")))
    rubs = {"fc_pos": 0.5, "fc_neg": 0.5, "v_dead": 1e-4, "v_full": 1e-3, "v_max": 0.1}  # or there is nothing to export
    constants = replace(no_compensation(3), **{name: np.full(3, value) for name, value in rubs.items()})
    save_compensation(constants, folder / "machine")
    data = holds(80, 4)
    force = load_machine(folder / "machine").robot.forces(data.q) + 1.5 * np.sign(data.v)
    noise = 0.1 * np.random.default_rng(1).standard_normal(data.shape)
    write_log(folder / "log.csv", data.t_s, data.q, data.v, force + noise)
    shutil.copytree(ROOT / "weights" / "arm2", folder / "arm")
    friction = '\n[[effects]]\nname = "coulomb_friction"\nparams = {fc_1 = 0.5}\n'
    (folder / "arm" / "model.toml").write_text((folder / "arm" / ROBOT_TOML).read_text() + friction)
    rng = np.random.default_rng(2)
    torch_like(folder / "net.onnx", w=rng.normal(size=(9, 3)), v=rng.normal(size=(3, 9)), c=np.zeros(3), width=3)
    (folder / "limits.toml").write_text(LIMITS + MOTION)
    (folder / "turn.txt").write_text("Time,Position,Iq\n" + "".join(f"{k},{k / 99},0.1\n" for k in range(40)))
    return folder


def opened(place, commands: dict[str, list[str]]) -> dict[str, set]:
    """Files that each command opens; all of them must end well."""
    run = subprocess.run(
        [sys.executable, str(ROOT / "tb" / "opened.py")],
        cwd=place,
        env={**os.environ, "PYTHONPATH": str(ROOT / "sim"), "OMP_NUM_THREADS": "1"},
        input=json.dumps([[name, *arguments] for name, arguments in commands.items()]),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return {name: set(map(Path, files)) for name, files in zip(commands, json.loads(run.stdout), strict=True)}


def is_elsewhere(path: Path, place: Path) -> bool:
    """A robot.toml that is not of the working folder, or what the tree has of a machine."""
    parents = set(path.parents)
    return (path.name == ROBOT_TOML and place not in parents) or not parents.isdisjoint(OTHERS)


SHORT = ("--poses", "8", "--legs", "2", "--timeout", "3")
CASES = {
    "train": ["--from", "machine", "--out", "trained", "--poses", "20"],
    "adopt": ["machine"],
    "formats": ["--weights", "machine"],
    "certify": ["machine", "--gap", "20"],
    "rom": ["--weights", "machine", "--out", "generated"],
    "image": ["--weights", "machine", "--rom", "machine", "--out", "image.bin"],
    "diagnose": ["log.csv", "--robot", "machine", "--out", "report"],
    "loop": ["log.csv", "--weights", "machine", "--save", "next"],
    "measure": ["--robot", "machine", "--points", "40", "--out", "measured.csv"],
    "import": ["anticogging", "turn.txt", "--out", "imported.csv"],
    "plan": ["log.csv", "--robot", "machine", "--report", "report"],
    "new": ["project", "--robot", "machine"],
    "import-network": ["net.onnx", "--robot", "machine", "--out", "imported", "--poses", "200"],
    "correct": ["arm/model.toml", "--out", "arm/corrected.xml"],
    "export": ["csv", "--weights", "machine", "--out", "tables"],
    "vectors": ["--weights", "machine", "--out", "vectors.txt"],
    "board": ["PORT", "info", "--robot", "machine"],
    "campaign": ["PORT", "--robot", "machine", "--limits", "limits.toml", "--out", "campaign", *SHORT],
}
WITHOUT_A_ROBOT = {"import", "correct"}  # correct reads the model.toml that a diagnosis wrote


def core_of(machine: Path) -> WholeModel:
    """Registers of a core with four lanes that was built with the ROM of a machine of three axes."""
    told = machine_settings(machine)
    hashed = [told["expected_weights"], *range(7)]
    whole = partial(WholeModel, load_machine(machine), record_s=0.02)
    return mover(whole, clock_hz=told["clock_hz"], weights_hash=hashed)


def test_every_command_is_looked_at():
    assert set(CASES) == set(COMMANDS)


@pytest.mark.slow
def test_commands_read_no_robot_but_their_own(place):
    with ModelBoard(core_of(place / "machine")) as board:
        on_a_line = {name: [board.port, *CASES[name][1:]] for name in ("board", "campaign")}
        files = opened(place, CASES | on_a_line)
    own = place / "machine" / ROBOT_TOML
    assert {name for name in files if own not in files[name]} == WITHOUT_A_ROBOT
    foreign = {name: [path for path in paths if is_elsewhere(path, place)] for name, paths in files.items()}
    assert foreign == {name: [] for name in CASES}


def test_a_look_at_the_shipped_robot_is_seen(place):
    files = opened(place, {"formats": ["--weights", str(SHIPPED)]})["formats"]
    assert SHIPPED / ROBOT_TOML in {path for path in files if is_elsewhere(path, place)}
