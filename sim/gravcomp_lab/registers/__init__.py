"""What `make regs` does beside PeakRDL."""
