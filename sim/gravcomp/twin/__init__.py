"""Bit-true models of the hardware, a module per group of entities of rtl/, and the bounds of their signals."""
