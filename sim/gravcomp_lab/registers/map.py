"""The register map of a core of so many axes, from its description; the driver's is that of eight."""

import tempfile
from functools import cache
from pathlib import Path

from peakrdl_ipxact import IPXACTExporter, Standard

from gravcomp.core.vhdl.registers import REGISTERS, elaborated
from gravcomp.driver.registers import Register, read_registers


@cache
def registers_of(n_axes: int, description: str = REGISTERS) -> dict[str, Register]:
    """The registers of a description by name, as read_registers has them."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "registers.xml"
        IPXACTExporter(standard=Standard.IEEE_1685_2009).export(elaborated(description, n_axes), str(path))
        return read_registers(path)
