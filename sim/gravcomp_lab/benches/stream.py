"""Drives an entity with in_valid/out_valid ports and records what comes out, and when."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from gravcomp_lab.benches.ports import driver, is_high, unsigned

# Clocks in which an input must be taken, gaps between them included.
PATIENCE = 10_000


@dataclass
class Recording:
    """Clocks (0-based) in which inputs were accepted and outputs valid, and the outputs as unsigned integers."""

    accepted: list[int] = field(default_factory=list)
    valid: list[int] = field(default_factory=list)
    outputs: dict[str, list[int]] = field(default_factory=dict)


async def start(dut) -> None:
    """Start a 10 ns clock and hold reset for three clocks. Signals are driven and read on falling edges."""
    Clock(dut.clk, 10, "ns").start(start_high=False)
    dut.rst.value = 1
    dut.in_valid.value = 0
    for _ in range(3):
        await FallingEdge(dut.clk)
    dut.rst.value = 0


async def stream(
    dut,
    inputs: Sequence[Mapping[str, int]],
    outputs: Sequence[str],
    *,
    spacing: int = 1,
    gap_probability: float = 0.0,
    rng: np.random.Generator | None = None,
    holds: bool = False,
    flush_clocks: int = 64,
    has_ready: bool = False,
) -> Recording:
    """Offer the inputs in order, spacing or more clocks apart, with random gaps; record flush_clocks beyond the last.

    Between inputs the data ports carry other ones of the list, unless holds: nothing may look at them without in_valid.
    has_ready: the entity has in_ready, which is then honoured. It is not looked up: GHDL 5.0.1 can die of looking for
    a name that is missing (grt-avhpi.adb:593). An output clock is one in which out_valid was high, an input clock the
    one at whose end the entity takes the input.
    """
    recording = Recording(outputs={name: [] for name in outputs})
    read = [(recording.outputs[name], unsigned(getattr(dut, name))) for name in outputs]
    drive = cache(lambda name: driver(getattr(dut, name)))
    offer, is_out, falling = driver(dut.in_valid), is_high(dut.out_valid), FallingEdge(dut.clk)
    is_ready = is_high(dut.in_ready) if has_ready else lambda: True
    clock, idle, position, next_free = 0, 0, 0, 0
    while idle < flush_clocks:
        if is_out():
            recording.valid.append(clock)
            for values, ask in read:
                values.append(ask())
        may_offer = position < len(inputs) and clock >= next_free
        offers = may_offer and not (gap_probability and rng.random() < gap_probability)
        offer(int(offers))
        if offers or not holds:
            for name, value in inputs[position if offers else -1 - position % len(inputs)].items():
                drive(name)(value)
        if offers and is_ready():
            recording.accepted.append(clock)
            position += 1
            next_free = clock + spacing
        assert idle or clock < next_free + PATIENCE, f"input {position} was not taken in {PATIENCE} clocks"
        idle = idle + 1 if position == len(inputs) else 0
        clock += 1
        await falling
    return recording


async def after_resets(dut, inputs, outputs, clocks_before: Sequence[int], **options) -> list[Recording]:
    """The recordings of the inputs, streamed anew after each of several resets in mid-stream.

    A reset lasts one clock, with in_valid, after clocks_before clocks of the stream: what was under way, and what came
    with the reset, must not show up in a recording. options: those of stream.
    """
    recordings, spacing = [], options.get("spacing", 1)
    for n_clocks in clocks_before:
        for clock in range(n_clocks + 1):
            dut.in_valid.value = int(clock == n_clocks or clock % spacing == 0)
            dut.rst.value = int(clock == n_clocks)
            for name, value in inputs[clock // spacing % len(inputs)].items():
                getattr(dut, name).value = value
            await FallingEdge(dut.clk)
        dut.rst.value = 0
        recordings.append(await stream(dut, inputs, outputs, **options))
    return recordings


def latencies(recording: Recording) -> set[int]:
    """Clocks from each accepted input to its output."""
    return {out - taken for taken, out in zip(recording.accepted, recording.valid, strict=True)}
