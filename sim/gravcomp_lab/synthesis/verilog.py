"""The files of rtl/ by entity, and their Verilog."""

from pathlib import Path

from gravcomp.core.vhdl.verilog import analysed, repair, rtl_sources, synthesised, to_verilog
from gravcomp.errors import InputError

__all__ = ["analysed", "handwritten_sources", "repair", "rtl_sources", "source_of", "synthesised", "to_verilog"]


def source_of(rtl: Path, entity: str) -> Path:
    """The file of rtl/sources.f that holds an entity or a package; InputError when there is none."""
    for path in rtl_sources(rtl):
        if path.stem == entity:
            return path
    raise InputError(f"{rtl / 'sources.f'}: no file {entity}.vhd")


def handwritten_sources(rtl: Path) -> dict[str, Path]:
    """The files of rtl/sources.f that no program writes, by entity or package."""
    return {path.stem: path for path in rtl_sources(rtl) if path.parent.name not in ("generated", "registers")}
