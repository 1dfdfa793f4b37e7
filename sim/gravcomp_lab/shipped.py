"""The machine folder that the repository ships and measures itself on."""

from functools import cache
from pathlib import Path

from gravcomp.robot.machine import Machine, load_machine
from gravcomp.shipped import shipped

ROOT = Path(__file__).resolve().parents[2]
SPHEIRO = shipped("weights/spheiro")


@cache
def shipped_machine() -> Machine:
    return load_machine(SPHEIRO)
