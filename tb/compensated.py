"""A weights folder with a compensator that uses everything it can, each axis another part of it."""

from pathlib import Path

import numpy as np

from gravcomp.core.compensation import Compensation, load_compensation
from gravcomp.core.compensator_tables import FixedCompensation, quantise_compensation
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.robot.machine import load_machine, parse_machine
from machines import changed, machine_folder

N_AXES = 3
# A clock so slow that the simulator's axes move as fast as real ones: 16 clocks per 4 counts are 2.5 mm/s.
SLOW = parse_machine(changed(("clock_hz = 40e6", "clock_hz = 1e4")), "a slow core")
CSV = """\
axis,name,value
all,v_dead,2e-4
all,v_full,4e-4
1,fc_pos,1.7
1,fc_neg,1.1
1,stribeck,0.9
1,vs,0.002
1,b_pos,310
1,b_neg,250
1,v_max,0.02
2,fc_pos,-0.4
2,fc_neg,130
2,mu,0.999999
2,pitch,0.032
2,a1,100
2,a3,20
2,p3_rad,1
3,pitch,0.00513
3,a1,0.8
3,p1_rad,0.4
3,a2,0.3
3,p2_rad,-2
"""


def compensated_weights(folder: Path, csv: str = CSV, machine: str = SLOW.text) -> Path:
    """Write a machine folder with this compensation.csv and robot.toml, and its packages in generated/."""
    machine_folder(folder, text=machine)
    (folder / "compensation.csv").write_text(csv)
    write_rom(folder, folder / "generated")
    return folder


def constants(folder: Path) -> tuple[Compensation, FixedCompensation]:
    """The constants in a weights folder, and the hardware's tables of them."""
    compensation = load_compensation(folder, N_AXES)
    return compensation, quantise_compensation(compensation, load_machine(folder).drive, folder)


def draw_periods(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Signed periods of 32 bits, uniform in their logarithm, one in four at or beside a corner of the code."""
    periods = np.floor(2.0 ** rng.uniform(0, 31, shape)).astype(np.int64)
    corners = 2 ** rng.integers(0, 32, shape) + rng.integers(-1, 2, shape)
    periods = np.where(rng.random(shape) < 0.25, corners, periods) * rng.choice([-1, 1], shape)
    return np.clip(periods, -(2**31), 2**31 - 1)
