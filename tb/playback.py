"""Plays input arrays into a running entity clock by clock and records its outputs, to compare with a bit-true model."""

from collections.abc import Iterable, Mapping

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer


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
    drivers = [(getattr(dut, name), np.asarray(values).tolist(), [None]) for name, values in inputs.items()]
    handles = {name: getattr(dut, name) for name in outputs}
    recorded = {name: (h, np.zeros(n_clocks, np.int64 if len(h) <= 64 else object)) for name, h in handles.items()}
    for k in range(n_clocks):
        for handle, values, last in drivers:
            if values[k] != last[0]:
                handle.value = last[0] = values[k]
        await Timer(1, "ns")
        for handle, values in recorded.values():
            value = handle.value
            values[k] = value.to_signed() if hasattr(value, "to_signed") else int(value)
        await FallingEdge(dut.clk)
    clock.stop()
    return {name: values for name, (_, values) in recorded.items()}


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
