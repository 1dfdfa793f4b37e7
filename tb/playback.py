"""Plays input arrays into a running entity clock by clock and records its outputs, to compare with a bit-true model."""

from collections.abc import Iterable, Mapping

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer

from gravcomp_lab.benches.ports import driver, signed


async def play(
    dut, inputs: Mapping[str, np.ndarray], outputs: Iterable[str], *, reset: bool = True
) -> dict[str, np.ndarray]:
    """Outputs by port name; element k of every array is the value just before rising clock edge k. Vectors are signed.

    reset gives one clock of rst before clock 0; without it clock 0 is the first that the entity ever sees.
    """
    clock = Clock(dut.clk, 10, "ns")
    dut.clk.value = 0
    dut.rst.value = int(reset)
    await Timer(1, "ns")
    clock.start(start_high=False)
    if reset:
        await FallingEdge(dut.clk)
        dut.rst.value = 0
    n_clocks = len(next(iter(inputs.values())))
    drivers = [(driver(getattr(dut, name)), np.asarray(values).tolist()) for name, values in inputs.items()]
    recorded = {name: np.zeros(n_clocks, np.int64 if len(getattr(dut, name)) <= 64 else object) for name in outputs}
    ports = [(signed(getattr(dut, name)), values) for name, values in recorded.items()]
    settled, falling = Timer(1, "ns"), FallingEdge(dut.clk)
    for k in range(n_clocks):
        for drive, values in drivers:
            drive(values[k])
        await settled
        for ask, values in ports:
            values[k] = ask()
        await falling
    clock.stop()
    return recorded


def assert_equal(recorded: Mapping[str, np.ndarray], expected: Mapping[str, np.ndarray]) -> None:
    """AssertionError that names port, clock and values of the first difference."""
    for name, values in recorded.items():
        differ = np.flatnonzero(values != expected[name])
        if len(differ):
            k = differ[0]
            raise AssertionError(
                f"{name} at clock {k}: got {values[k]}, expected {expected[name][k]} ({len(differ)} differ)"
            )
    cocotb.log.info("%d clocks equal: %s", len(values), ", ".join(recorded))


async def flush(dut, n_clocks: int, **inputs: int) -> None:
    """So many clocks in reset with these inputs, for registers that no reset clears; for play to follow."""
    dut.rst.value = 1
    for name, value in inputs.items():
        getattr(dut, name).value = value
    clock = Clock(dut.clk, 10, "ns")
    clock.start(start_high=False)
    for _ in range(n_clocks):
        await FallingEdge(dut.clk)
    clock.stop()
