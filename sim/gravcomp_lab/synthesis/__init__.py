"""From VHDL to area and clock with free tools: GHDL, Yosys, nextpnr."""
