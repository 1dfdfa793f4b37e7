"""Parquet: columns by name; a unit where the field's metadata has one under ``unit``."""

from pathlib import Path

import numpy as np

from gravcomp.errors import InputError, optional
from gravcomp.logs.importers.signals import Signal


def parquet_signals(path: Path) -> dict[str, Signal]:
    """Columns of the file that are numbers; empty cells are NaN. Raises InputError."""
    arrow, parquet = (optional(part, "pyarrow", "a Parquet file") for part in ("pyarrow", "pyarrow.parquet"))
    try:
        table = parquet.read_table(path)
    except (OSError, arrow.ArrowException) as error:
        raise InputError(f"{path}: no Parquet file ({error}); give a .parquet") from error
    out = {}
    for field, values in zip(table.schema, table.columns, strict=True):
        if arrow.types.is_timestamp(field.type):
            values = values.cast(arrow.timestamp("ns")).cast(arrow.int64())
        if arrow.types.is_integer(values.type) or arrow.types.is_floating(values.type):
            unit = (field.metadata or {}).get(b"unit", b"").decode()
            out[field.name] = Signal(np.asarray(values.to_pandas(), float), unit)
    return out
