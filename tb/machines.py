"""The shipped machine, and machine folders that differ from it."""

import shutil
from functools import cache
from pathlib import Path

import numpy as np

from gravcomp.core.provenance import write_provenance
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.network.weights import Network, save_network
from gravcomp.robot.machine import ROBOT_TOML, Drive, load_machine
from gravcomp_lab.forms import form_copy
from runner import BUILD, RTL

SHIPPED = Path(__file__).resolve().parents[1] / "weights" / "spheiro"
MACHINE = load_machine(SHIPPED)
P = MACHINE.robot.parameters


def like_shipped(n_axes: int) -> Drive:
    """The shipped machine's encoders, motors and clock on n axes."""
    return Drive(np.full(n_axes, 1e6), np.full(n_axes, 45.0), MACHINE.clock_hz)


def machine_folder(folder: Path, network: Network | None = None, text: str = MACHINE.text) -> Path:
    """Write a machine folder like the shipped one, with another network or text of robot.toml, and its provenance."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("hidden.csv", "output.csv", "scaling.csv"):
        shutil.copy(SHIPPED / name, folder)
    (folder / ROBOT_TOML).write_text(text)
    if network is not None:
        save_network(network, folder)
    write_provenance(folder, command="a test", data={}, metrics={}, machine=load_machine(folder))
    return folder


def rtl_of(weights: Path, out: Path) -> Path:
    """A copy of the VHDL in a new folder, with the ROM of a machine folder."""
    shutil.copytree(RTL, out)
    write_rom(weights, out / "generated")
    return out


def changed(*pairs: tuple[str, str], text: str = MACHINE.text) -> str:
    """robot.toml with each first part of a pair, which must stand in it, replaced by the second."""
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


@cache
def shipped_in(form: str) -> tuple[Path, Path]:
    """The shipped machine in another form, and a folder with its packages."""
    folder, generated = form_copy(SHIPPED, BUILD, form), BUILD / form / "generated"
    write_rom(folder, generated)
    return folder, generated
