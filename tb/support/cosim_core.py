"""A core under Verilator for the tests that need one: a vertical slide, compiled once for all of them."""

from pathlib import Path

from gravcomp.cli import main
from gravcomp.robot.machine import ROBOT_TOML
from gravcomp.shipped import shipped
from gravcomp_lab.cosim.library import build, slow_machine
from runner import BUILD, ROOT

STEP_CLOCKS = 80  # one axis needs fewer
# A tenth of a metre: a campaign in a minute of the robot's time.
RANGE = "low = 0.2\nhigh = 0.3\n"


def slide_core(name: str) -> tuple[Path, Path]:
    """The library, and a machine folder of its own for the test of this name."""
    folder = slow_machine(shipped("weights/slide"), BUILD / "tb" / name / "slide", STEP_CLOCKS)
    with (folder / ROBOT_TOML).open("a") as file:
        file.write(RANGE)
    assert main(["adopt", str(folder)]) == 0
    return build(folder, ROOT / "rtl", BUILD / "tb" / "slide_core"), folder
