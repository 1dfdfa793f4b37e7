"""A project folder: one machine and what takes it to an FPGA, without the repository."""
