"""The machine folders that the repository ships; it measures itself on the Sphe.I.Ro. unless another is named."""

from functools import cache
from pathlib import Path

from gravcomp.robot.machine import Machine, load_machine
from gravcomp.shipped import shipped

SPHEIRO = shipped("weights/spheiro")
ROOT = Path(__file__).resolve().parents[2]
SPHEIRO = shipped("weights/spheiro")


@cache
def shipped_machine(name: str = "spheiro") -> Machine:
    return load_machine(shipped(f"weights/{name}"))
