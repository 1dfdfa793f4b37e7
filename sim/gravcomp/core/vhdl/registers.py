"""Writes the VHDL of the registers of a core, from their one description, for its number of axes."""

import tempfile
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path

from gravcomp.core.vhdl.plain_vhdl import plain
from gravcomp.core.vhdl.small_registers import retimed, small
from gravcomp.errors import InputError
from gravcomp.shipped import shipped

REGISTERS, MOTION_REGISTERS = "gc_registers", "gc_motion_registers"
REGISTER_FILES = tuple(f"{name}{end}.vhd" for name in (REGISTERS, MOTION_REGISTERS) for end in ("_pkg", ""))
_ADDRESS_BITS = 12


@cache
def register_files(n_axes: int) -> dict[str, str]:
    """gc_registers, gc_motion_registers and their packages for so many axes, text by file name.

    Raises InputError as elaborated does, and as retimed and small.
    """
    written = peakrdl_files(n_axes)
    return {name: text if name.endswith("_pkg.vhd") else small(retimed(text)) for name, text in written.items()}


def peakrdl_files(n_axes: int) -> dict[str, str]:
    """The same as PeakRDL writes them, but plain."""
    from peakrdl_regblock_vhdl import RegblockExporter
    from peakrdl_regblock_vhdl.cpuif.axi4lite import AXI4Lite_Cpuif_flattened

    with tempfile.TemporaryDirectory() as folder:
        for description in (REGISTERS, MOTION_REGISTERS):
            RegblockExporter().export(
                elaborated(description, n_axes),
                folder,
                cpuif_cls=AXI4Lite_Cpuif_flattened,
                reuse_hwif_typedefs=False,
                address_width=_ADDRESS_BITS,
                default_reset_activelow=False,
                default_reset_async=False,
                err_if_bad_addr=True,
                err_if_bad_rw=True,
            )
        written = {name: (Path(folder) / name).read_text(encoding="utf-8") for name in REGISTER_FILES}
    return {name: plain(text) for name, text in written.items()}


def elaborated(description: str, n_axes: int):
    """The root of a description of registers for so many axes, as PeakRDL's exporters take it.

    Raises InputError when the description was damaged.
    """
    from systemrdl import RDLCompileError, RDLCompiler

    compiler, path = RDLCompiler(), shipped(f"rtl/registers/{description}.rdl")
    try:
        with as_file(files("peakrdl_regblock_vhdl") / "hdl_src" / "regblock_udps.rdl") as properties:
            compiler.compile_file(str(properties))
        compiler.compile_file(str(path))
        return compiler.elaborate(parameters={"AXES": n_axes})
    except RDLCompileError as error:
        raise InputError(f"{path}: {error}; put back the file that came with gravcomp") from None
