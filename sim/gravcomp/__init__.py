"""gravcomp: gravity compensation of a spherical parallel robot in an FPGA.

Read in this order: ``robot`` (physics), ``network`` (training, formats, bit-true model, ROM),
``measured`` (measured data, effects, diagnosis).
"""
