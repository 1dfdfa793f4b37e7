"""What the encoders' wires do to gc_system: counts that are lost engage the brakes, and the cause is `encoder`."""

import cocotb
import numpy as np
import pytest

from encoder_losses import SUSPECT_COUNTS, rate_counts
from gravcomp.twin.encoder import DecoderConfig
from gravcomp.twin.safety import Cause
from runner import simulate
from support.board import MOTION_CLOCKS, Board

CONFIG = DecoderConfig()
SPEED_TIMEOUT = 2000
AXIS = 1


async def running(dut, period: int = 0, pause: int = 250, **settings) -> Board:
    board = Board(dut)
    await board.start()
    board.period = period
    await board.configure(**settings)
    await board.run(pause)
    return board


async def braked_by(board: Board, cause: Cause) -> None:
    """The brakes are engaged, and nothing but this came first, with the reference that goes with lost counts."""
    await board.clocks(60)
    await board.wait_for_state("fault")
    assert not board.is_released()
    also = Cause.UNREFERENCED.mask if cause == Cause.ENCODER else 0
    assert await board.registers.read("first_cause") == cause.mask | also


async def still_runs(board: Board) -> None:
    await board.clocks(60)
    await board.wait_for_state("run")
    assert await board.registers.read("cause") == 0
    assert await board.registers.read_axes("position_now") == board.position
    await board.clocks(1)


@cocotb.test()
@cocotb.parametrize(wire=["a", "b"], level=[0, 1], at_rest=[False, True])
async def a_broken_wire_is_found(dut, wire, level, at_rest):
    """Within the counts that docs/guide/safety.md states; with all wires whole the same motion is none."""
    board = await running(dut)
    assert await board.move(AXIS, 60) == 60
    await still_runs(board)
    await board.clocks(3 * CONFIG.reversal_clocks if at_rest else 0)
    board.wires[wire, AXIS] = level
    most = rate_counts(MOTION_CLOCKS, CONFIG.dither_clocks) if at_rest else SUSPECT_COUNTS
    assert await board.move(AXIS, 600) <= most
    await braked_by(board, Cause.ENCODER)


@cocotb.test()
@cocotb.parametrize(period=[0, 40])
async def a_broken_wire_of_a_slow_axis_is_found_at_a_mark(dut, period):
    board = await running(dut, period, watchdog_clocks=10**7)
    await board.move(AXIS, 6, 300)
    board.wires["b", AXIS] = 0
    assert await board.move(AXIS, 22, 300) == 22
    counts = await board.move(AXIS, -50, 300) if period == 0 else await board.move(AXIS, 50, 300)
    assert counts <= (50 if period == 0 else 40)
    await braked_by(board, Cause.ENCODER)


@cocotb.test()
async def a_mark_in_the_wrong_place_is_lost_counts(dut):
    board = await running(dut)
    board.wires["z", AXIS] = 1
    assert 4 < await board.move(AXIS, 20) <= 7  # more than a cycle from its index, and the clocks to find it
    await braked_by(board, Cause.ENCODER)


@cocotb.test()
async def a_dropped_level_that_costs_counts_is_lost_counts(dut):
    """a low for three clocks, b falls in the middle; a pulse of a alone is only a warning."""
    board = await running(dut)
    level = int(dut.pin_a.value)
    for flipped in (level ^ 1 << AXIS, level):
        dut.pin_a.value = flipped
        await board.clocks(3)
    await still_runs(board)
    assert await board.registers.field("encoder_flags", "glitch") == 1 << AXIS
    await board.clocks(1)
    await board.move(AXIS, 8)
    for clocks in (1, 2, 10, 10):
        await board.move(AXIS, 1, clocks)
    await braked_by(board, Cause.ENCODER)


@cocotb.test()
async def beyond_the_limit_speed_counts_are_lost(dut):
    board = await running(dut)
    for clocks in (12, 10, 8, 6, 5, 4, 3):
        assert await board.move(AXIS, 40, clocks) == 40
    await still_runs(board)
    for _ in range(300):
        await board.move(AXIS, 1, 1)
        await board.move(AXIS, 1, 2)
    await braked_by(board, Cause.ENCODER)


@cocotb.test()
async def no_speed_limit_switches_the_supervision_off(dut):
    """8 clocks per 4 counts are the fastest that can be measured; 0, the reset value, allows no motion at all.

    With 0 the brakes open once the axes stand still: after homing they do not yet.
    """
    for limit, clocks in ((8, 2), (0, 60)):
        board = await running(dut, pause=SPEED_TIMEOUT, period_min_clocks=limit)
        assert await board.move(AXIS, 400, clocks) <= 12  # five edges, and the clocks to see them
        await braked_by(board, Cause.SPEED)


@cocotb.test()
async def an_index_that_never_falls_is_no_reference(dut):
    board = Board(dut)
    await board.start()
    board.wires = {("z", axis): 1 for axis in range(3)}
    board.drive()
    await board.configure()
    await board.home()
    await board.registers.read("result_number")
    assert await board.registers.field("encoder_flags", "referenced") == 0
    assert await board.registers.field("encoder_flags", "illegal") == 0, "a reference that was lost again"
    assert await board.registers.read("cause") & Cause.UNREFERENCED.mask
    board.wires = {}
    board.drive()
    await board.home()
    await board.registers.read("result_number")
    assert await board.registers.field("encoder_flags", "referenced") == 7


@cocotb.test()
async def the_error_output_of_a_receiver_engages_the_brakes(dut):
    for axis in range(3):
        board = await running(dut)
        await board.clocks(1)
        dut.pin_error.value = 1 << axis
        await board.clocks(CONFIG.sync_stages + 1 + 2)
        assert not board.is_released()
        dut.pin_error.value = 0
        await braked_by(board, Cause.ENCODER)


@cocotb.test()
async def dither_about_one_edge_is_no_fault_while_other_axes_move(dut):
    board = await running(dut, watchdog_clocks=10**6)
    await board.clocks(2 * CONFIG.reversal_clocks)
    rng = np.random.default_rng(31)
    cocotb.log.info("seed 31")
    start = board.position[AXIS]
    for spacing in (CONFIG.dither_clocks, 75, 400):
        for k in range(6000 // spacing):
            board.position[AXIS] = start + k % 2
            for _ in range(spacing // MOTION_CLOCKS):
                for axis in (0, 2):
                    board.position[axis] += int(rng.choice([-1, 1, 1]))
                board.drive()
                await board.clocks(MOTION_CLOCKS)
            await board.clocks(spacing % MOTION_CLOCKS)
    assert board.is_released()
    await still_runs(board)


@pytest.mark.parametrize(
    "name",
    [
        "a_broken_wire_is_found",
        "a_broken_wire_of_a_slow_axis_is_found_at_a_mark",
        "a_mark_in_the_wrong_place_is_lost_counts",
        "a_dropped_level_that_costs_counts_is_lost_counts",
        "beyond_the_limit_speed_counts_are_lost",
        "no_speed_limit_switches_the_supervision_off",
        "an_index_that_never_falls_is_no_reference",
        "the_error_output_of_a_receiver_engages_the_brakes",
        "dither_about_one_edge_is_no_fault_while_other_axes_move",
    ],
)
def test_encoder_fault(name):
    generics = {"lanes_g": 1, "loadable_g": "false", "speed_timeout_g": SPEED_TIMEOUT}
    simulate("gc_system", "test_rtl_encoder_faults", tests=rf"\.{name}(/|$)", label=name, generics=generics)
