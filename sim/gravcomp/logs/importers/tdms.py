"""TDMS, as LabVIEW writes it: channels by name, ``group/channel`` where two groups have the same, unit and clock."""

from pathlib import Path

import numpy as np

from gravcomp.errors import InputError, optional
from gravcomp.logs.importers.signals import Signal


def tdms_signals(path: Path) -> dict[str, Signal]:
    """Channels of the file. Raises InputError."""
    nptdms = optional("nptdms", "nptdms", "a TDMS file")
    try:
        file = nptdms.TdmsFile.read(path)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path}: no TDMS file ({error}); give a .tdms") from error
    channels = [channel for group in file.groups() for channel in group.channels()]
    names = [channel.name for channel in channels]
    return {
        channel.name if names.count(channel.name) == 1 else f"{channel.group_name}/{channel.name}": _signal(channel)
        for channel in channels
        if np.issubdtype(channel.dtype, np.number)
    }


def _signal(channel) -> Signal:
    has_clock = "wf_increment" in channel.properties
    t_s = channel.time_track() if has_clock else None
    return Signal(np.asarray(channel[:], float), str(channel.properties.get("unit_string", "")), t_s)
