"""Other files as the measured CSV: public data sets of real machines, and containers of signals; a module per kind."""

import importlib
from pathlib import Path

DATA_SETS = ("anticogging", "emps")
CONTAINERS = {"mat": "mat", "mcap": "joint_states", "mdf": "mdf", "parquet": "parquet", "rosbag": "joint_states",
              "tdms": "tdms"}  # fmt: skip


def convert(kind: str, path: Path | str) -> str:
    """The measured CSV of a data set as published: <kind>_csv of the module <kind>. Raises InputError."""
    return getattr(importlib.import_module(f"{__name__}.{kind}"), f"{kind}_csv")(path)


def convert_signals(kind: str, path: Path, columns: dict[str, str], **options) -> str:
    """The measured CSV of a container: what <kind>_signals of its module reads, as columns say. Raises InputError.

    A module may have a default_columns, for what columns do not say.
    """
    from gravcomp.logs.importers.signals import measured_csv

    module = importlib.import_module(f"{__name__}.{CONTAINERS[kind]}")
    signals = getattr(module, f"{kind}_signals")(path, **options)
    defaults = module.default_columns(signals) if hasattr(module, "default_columns") else {}
    told = {target.partition("_")[0] for target in columns}
    return measured_csv(
        path, signals, {**{t: name for t, name in defaults.items() if t.partition("_")[0] not in told}, **columns}
    )
