"""Really measured data, where they can be had: in ../shared/data or the folder named by GRAVCOMP_DATA."""

import os
from pathlib import Path

import pytest

from codes import ROOT

FOLDERS = [os.environ.get("GRAVCOMP_DATA"), ROOT.parent / "shared" / "data"]


def published(name: str) -> str:
    """Path of a file of the data; skips the test where it is not there."""
    for folder in FOLDERS:
        if folder and (Path(folder) / name).exists():
            return str(Path(folder) / name)
    pytest.skip(f"{name} is neither in ../shared/data nor in GRAVCOMP_DATA")
