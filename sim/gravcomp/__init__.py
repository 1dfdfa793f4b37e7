"""gravcomp: gravity compensation of a robot in an FPGA.

Read in this order: ``robot`` (physics), ``network`` and ``training``, ``core`` (what the FPGA holds), ``twin`` (its
bit-true models), ``logs`` (measured data), ``diagnosis`` (what a model lacks), ``loop`` (that into the hardware),
``prototype``, ``driver``.
"""

__version__ = "0.3.0"
