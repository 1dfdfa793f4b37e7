"""Machines of 1, 2, 6 and 7 axes, each with the ROM and the registers of its own; three axes are everywhere else."""

from functools import cache
from pathlib import Path

import numpy as np

from arm import arm_toml
from codes import ROOT
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.network.inputs import POSITION, SIN_COS
from gravcomp.network.weights import Network
from machines import machine_folder
from runner import BUILD

N_AXES = {"slide": 1, "arm2": 2, "so101": 6, "ur5": 6, "seven": 7}
N_HIDDEN = {"slide": 8, "arm2": 20, "so101": 40, "ur5": 20, "seven": 8}
# So that the compensator of each axis adds something: the same force map on all, over different pitches.
COGGING = "axis,name,value\nall,a1,0.05\n" + "".join(f"{axis},pitch,{0.1 * axis:g}\n" for axis in range(1, 8))


def random_network(inputs: tuple[str, ...], n_hidden: int) -> Network:
    """A network without meaning whose efforts, ranges and offsets differ from axis to axis."""
    n_axes, turns = len(inputs), np.array([kind == SIN_COS for kind in inputs])
    rng = np.random.default_rng(n_axes * 100 + n_hidden)
    return Network(
        hidden_weights=rng.uniform(-3, 3, (n_hidden, n_axes + turns.sum())),
        hidden_bias=rng.uniform(-1, 1, n_hidden),
        output_weights=rng.uniform(-1, 1, (n_axes, n_hidden)),
        output_bias=rng.uniform(-0.2, 0.2, n_axes),
        q_offset=np.where(turns, 0.0, rng.uniform(-0.05, 0.05, n_axes)),
        q_scale=np.where(turns, 1.0, rng.uniform(5, 8, n_axes)),
        f_offset=rng.uniform(-50, 50, n_axes),
        f_scale=rng.uniform(40, 70, n_axes),
        position_units=("rad",) * n_axes,
        inputs=inputs,
    )


@cache
def machine_of(name: str) -> tuple[Path, Path]:
    """The machine folder of a name, and a folder with its packages: a shipped one, or seven axes drawn by seed."""
    folder, generated = ROOT / "weights" / name, BUILD / "axes" / name / "generated"
    if name == "seven":
        folder = BUILD / "axes" / name / "weights"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "compensation.csv").write_text(COGGING)
        machine_folder(folder, random_network((POSITION,) * 7, N_HIDDEN[name]), arm_toml(7))
    write_rom(folder, generated)
    return folder, generated


def divisors(name: str) -> list[int]:
    """The numbers of lanes that divide the hidden neurons of a machine."""
    return [lanes for lanes in range(1, N_HIDDEN[name] + 1) if N_HIDDEN[name] % lanes == 0]
