"""Writers of the generated VHDL packages."""
