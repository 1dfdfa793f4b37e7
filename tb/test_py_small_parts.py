"""The serial form on small parts: cells are those of tb/synthesis.csv, within what it is for; clock and time on a UP5K.

After an intended change, `REFRESH=1 pytest tb/test_py_small_parts.py -k pinned` writes the cells anew, under one lane.
"""

import os

import pytest

from gravcomp.core.cost import CoreCost
from gravcomp_lab.synthesis.around import scan_cells, scanned
from gravcomp_lab.synthesis.place_route import PlacedClock, PlacedDesign
from gravcomp_lab.synthesis.small_parts import (
    CLOCK,
    PARTS,
    TOPS,
    SmallResult,
    chain_cells,
    place_small,
    small_netlist,
    small_table,
)
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from gravcomp_lab.synthesis.yosys import Netlist, synthesise
from machines import shipped_in
from runner import RTL
from test_py_synthesis import pinned, refresh

UP5K, GW1N, GW2A = PARTS
PORT_BITS = {"input": 3 * 32 + 2, "output": 3 * 24 + 2 + 3 + 3}  # counts, in_valid, rst; forces, handshake, flags


def netlist(target: str, folder, **options) -> Netlist:
    _, generated = shipped_in("serial")
    verilog = to_verilog(rtl_sources(RTL, generated), "gc_core_serial", {}, folder / "core.v")
    return synthesise(verilog, "gc_core_serial", target, folder, **options)


@pytest.mark.parametrize("target", ["ice40", "gw1n"])
def test_serial_cells_are_those_pinned(target, tmp_path):
    cells = netlist(target, tmp_path).cells
    found = {(1, target, name): number for name, number in cells.items() if name != "$scopeinfo"}
    assert not [name for name in cells if "dlatch" in name.lower()]
    if os.environ.get("REFRESH"):
        refresh(found)
    assert found == {key: number for key, number in pinned().items() if key[1] == target}


def test_pinned_cells_are_two_blocks_for_the_product_and_memories_for_words_and_h():
    """An operand's 16 upper bits by a weight, and its two lowest; on Gowin the latter are logic."""
    numbers = {key[1:]: n for key, n in pinned().items()}
    assert numbers["ice40", "SB_MAC16"] == 2
    assert numbers["ice40", "SB_RAM40_4K"] == 6  # words of 64 bits at most, h of 18, 16 bits each
    assert numbers["gw1n", "MULT18X18"] == 1


@pytest.mark.slow
def test_core_fits_a_up5k_at_its_clock(tmp_path):
    """At most 800 logic cells and 2 multipliers, at least 40 MHz, at most 5 us; a seed's clock is 5 % off another's."""
    chained = netlist("ice40", tmp_path, around=scanned(CLOCK))
    placed = place_small(chained, UP5K, 1, tmp_path / "placed")
    result = SmallResult("gc_core_serial", UP5K, 149, chain_cells(chained, UP5K), (placed,))
    assert result.chain_cells == sum(PORT_BITS.values())
    assert result.logic <= 800
    assert result.used(UP5K.multiplier) <= 2
    assert placed.clock.mhz >= 40
    assert result.latency / placed.clock.mhz <= 5


@pytest.mark.slow
def test_pins_to_currents_fit_a_up5k(tmp_path):
    """Three decoders, the network, a current per axis, with the chain at their ports."""
    (path,) = (top for top in TOPS if top.entity == "gc_force_path")
    _, generated = shipped_in("serial")
    chained = small_netlist(rtl_sources(RTL, generated), path, UP5K, tmp_path)
    used = place_small(chained, UP5K, 1, tmp_path / "placed").used
    assert used["ICESTORM_LC"] <= UP5K.available
    assert used[UP5K.multiplier] <= 8


def test_clocks_from_pins_are_those_of_the_header():
    """gc_core_serial 149, three currents in turn 4 + 3, commands 1; of one axis 4 alone."""
    core, path = TOPS
    costs = [CoreCost(20, n, n, 1, True, True) for n in (3, 1)]
    assert [core.clocks(cost) for cost in costs] == [149, 109]
    assert [path.clocks(cost) for cost in costs] == [149 + 8, 109 + 5]


@pytest.mark.slow
@pytest.mark.parametrize("part", [GW1N, GW2A], ids=lambda part: part.name)
def test_core_is_placed_on_gowin(part, tmp_path):
    placed = place_small(netlist(part.target, tmp_path, around=scanned(CLOCK)), part, 1, tmp_path / "placed")
    assert placed.used[part.multiplier] == 1
    assert placed.clock.mhz >= 40


def test_chain_shifts_through_every_port_and_captures_the_outputs(tmp_path):
    """A flip-flop per bit of every port; the ports of the top are four."""
    chained = netlist("generic", tmp_path, around=scanned(CLOCK))
    inputs, outputs = PORT_BITS.values()
    assert scan_cells(chained.ports, CLOCK) == (outputs, inputs + outputs)
    assert chained.port_bits() == 4


def test_table_tells_cells_without_the_chain_and_time_at_the_median():
    placed = [
        PlacedDesign(
            {"clk": PlacedClock(mhz, "a", "b", 1.0)}, {"ICESTORM_LC": 700, "ICESTORM_DSP": 2, "ICESTORM_RAM": 6}
        )
        for mhz in (40.0, 50.0, 60.0)
    ]
    result = SmallResult("gc_x", UP5K, 150, 172, tuple(placed))
    row = "| `gc_x` | iCE40 UP5K | 528 | 10 % | 172 | 2 | 6 | 50; 40-60 | 150 | 3.00 |"
    assert small_table([result]).splitlines()[2] == row


def test_gowin_counts_carry_cells_and_no_lonely_flip_flop(tmp_path):
    ports = {"in_count": ("input", 98), "out_force": ("output", 80), "clk": ("input", 1)}
    chained = Netlist("around", {}, tmp_path, tmp_path, ports)
    assert (chain_cells(chained, GW1N), chain_cells(chained, UP5K)) == (80, 178)
    assert GW1N.logic == ("LUT4", "ALU")
