"""Public data sets of real machines, converted to the measured CSV: a module per data set."""

import importlib
from pathlib import Path

IMPORTERS = ("anticogging", "emps")


def convert(kind: str, path: Path | str) -> str:
    """The measured CSV of a data set as published: <kind>_csv of the module <kind>. Raises InputError."""
    return getattr(importlib.import_module(f"{__name__}.{kind}"), f"{kind}_csv")(path)
