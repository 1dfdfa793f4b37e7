"""What the FPGA holds: formats, compensation and its tables, the image, and where all of it came from."""
