"""Waiting for a signal: for it to change, on every GHDL; for what must come, and no longer than that may take."""

from collections.abc import Callable

from cocotb.triggers import FallingEdge, NextTimeStep, ReadOnly


async def value_change(signal) -> None:
    """Return in the read-only phase of the time step in which the signal has another value than now.

    Not cocotb's ValueChange: GHDL 5.0.1 dies of it on a vector of 32 bits when that reaches 2^31 (grt-vpi.adb:1174).
    """
    before = signal.value
    while signal.value == before:
        await NextTimeStep()
        await ReadOnly()


async def until(clk, what: str, comes: Callable[[], bool], most_clocks: int) -> None:
    """Clocks, until it has come; AssertionError that says what did not when it takes more of them."""
    for _ in range(most_clocks):
        if comes():
            return
        await FallingEdge(clk)
    raise AssertionError(f"{what}: not within {most_clocks} clocks")
