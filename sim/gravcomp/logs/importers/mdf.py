"""ASAM MDF, versions 3 and 4: channels by name, each with its unit and clock."""

from pathlib import Path

import numpy as np

from gravcomp.errors import InputError, optional
from gravcomp.logs.importers.signals import Signal


def mdf_signals(path: Path) -> dict[str, Signal]:
    """Channels of the file that are numbers. Raises InputError."""
    asammdf = optional("asammdf", "asammdf", "an MDF file")
    try:
        file = asammdf.MDF(path)
    except (OSError, ValueError, asammdf.blocks.utils.MdfException) as error:
        raise InputError(f"{path}: no MDF file ({error}); give a .mf4, .mdf or .dat") from error
    with file:
        found = [file.get(name, *places[0]) for name, places in file.channels_db.items()
                 if places[0][1] != file.masters_db.get(places[0][0])]  # fmt: skip
    return {own.name: Signal(own.samples.astype(float), own.unit, own.timestamps) for own in found
            if own.samples.ndim == 1 and np.issubdtype(own.samples.dtype, np.number)}  # fmt: skip
