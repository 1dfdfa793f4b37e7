"""Waiting for a signal to change, on every GHDL."""

from cocotb.triggers import NextTimeStep, ReadOnly


async def value_change(signal) -> None:
    """Return in the read-only phase of the time step in which the signal has another value than now.

    Not cocotb's ValueChange: GHDL 5.0.1 dies of it on a vector of 32 bits when that reaches 2^31 (grt-vpi.adb:1174).
    """
    before = signal.value
    while signal.value == before:
        await NextTimeStep()
        await ReadOnly()
