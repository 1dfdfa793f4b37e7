"""gravcomp: gravity compensation of a spherical parallel robot in an FPGA.

Read in this order: ``robot`` (physics), ``network`` (training, formats, bit-true model, ROM),
``logs`` (measured data), ``diagnosis`` (what a model lacks), ``loop`` (that into the hardware), ``prototype``.
"""
