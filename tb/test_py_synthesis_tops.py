"""Whole tops on ECP5: scan chains around their ports, both clocks reported, cells of the chains not counted."""

import pytest

from gravcomp.errors import InputError
from gravcomp.robot.machine import LEAN
from gravcomp_lab.__main__ import main
from gravcomp_lab.synthesis.around import scan_cells, scanned
from gravcomp_lab.synthesis.place_route import PlacedClock, PlacedDesign, place_and_route, prepare
from gravcomp_lab.synthesis.tops import PlacedTop, Top, comb_of, part_of, row, slowest
from gravcomp_lab.synthesis.yosys import synthesise

CLOCKS = {"clk": (), "host": ("bus_", "irq")}
# Eight bits through a register in either clock; 600 bits of the one have no pins on any part.
DESIGN = """\
module two(input clk, input host, input [599:0] pin, input [7:0] bus_data, output reg [7:0] force, output reg irq);
  always @(posedge clk) force <= pin[7:0] ^ pin[599:592];
  always @(posedge host) irq <= ^bus_data;
endmodule
"""
SYSTEM = Top("gc_system", 1, True, LEAN)


@pytest.fixture(scope="module")
def netlist(tmp_path_factory):
    folder = tmp_path_factory.mktemp("two")
    (folder / "two.v").write_text(DESIGN)
    return synthesise(folder / "two.v", "two", "ecp5", folder, around=scanned(CLOCKS))


def test_ports_are_on_a_chain_per_clock(netlist):
    """Seven pins are left; ports that nothing uses are counted, as the port is used in part."""
    assert netlist.port_bits() == 7
    assert netlist.ports["pin"] == ("input", 600)
    # A LUT and a flip-flop per output, a flip-flop per input, of either clock.
    assert scan_cells(netlist.ports, CLOCKS) == (8 + 1, 8 + 1 + 600 + 8)
    own = netlist.cells["TRELLIS_FF"] - scan_cells(netlist.ports, CLOCKS)[1]
    assert own == 8 + 1


def test_both_clocks_are_reported_by_their_ports(netlist, tmp_path):
    prepare()
    placed = place_and_route(netlist.json, part="25k", speed=6, seed=1, out=tmp_path)
    assert set(placed.clocks) == set(CLOCKS)
    assert all(clock.mhz > 100 for clock in placed.clocks.values())


@pytest.mark.parametrize(
    ("cells", "part"),
    [
        ({"LUT4": 10_000, "CCU2C": 2000, "MULT18X18D": 28}, "25k"),
        ({"LUT4": 10_000, "MULT18X18D": 29}, "45k"),
        ({"LUT4": 20_000, "CCU2C": 1000}, "45k"),
        ({"LUT4": 1, "MULT18X18D": 73}, "85k"),
    ],
)
def test_part_is_the_smallest_that_holds_the_cells(cells, part):
    assert part_of(SYSTEM, cells) == part


def test_top_that_no_part_holds_is_refused():
    told = "gc_system 1 loadable lean: 200000 TRELLIS_COMB and 0 multipliers fit no part; take fewer lanes or axes"
    with pytest.raises(InputError, match=told):
        part_of(SYSTEM, {"LUT4": 200_000})


def test_a_carry_cell_takes_two_luts_and_a_distributed_ram_six():
    assert comb_of({"LUT4": 5, "CCU2C": 7, "TRELLIS_DPR16X4": 3, "TRELLIS_FF": 99}) == 5 + 14 + 18


def test_row_tells_the_median_and_the_range_of_each_clock():
    def run(core: float, host: float) -> PlacedDesign:
        return PlacedDesign(
            {"clk": PlacedClock(core, "a", "b", 9.0), "s_axi_aclk": PlacedClock(host, "c", "d", 8.0)}, {}
        )

    runs = {(6, 1): run(101.0, 120.0), (6, 2): run(99.0, 124.0), (6, 3): run(103.0, 122.0)}
    cells = {"LUT4": 8000, "CCU2C": 1000, "TRELLIS_FF": 9000, "MULT18X18D": 24, "DP16KD": 20}
    placed = PlacedTop(SYSTEM, "25k", cells, runs)
    numbers = "10000 | 9000 | 24 | 20 | 6: clk 101 (99-103); 6: s_axi_aclk 122 (120-124) |"
    assert row(placed) == f"| gc_system | 1 | loadable | lean | LFE5U-25F | {numbers}"
    assert slowest(placed)[1] == "- gc_system 1 loadable lean, s_axi_aclk: `c` to `d`, 8.0 ns"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--top", "gc_system", "--lanes", "0"], "--lanes 0: give 1 or more"),
        (["--jobs", "0"], "--jobs 0: need one or more"),
        (["--top", "gc_system", "--docs", "docs"], "--docs: the page shows all tops; leave --top out"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(arguments, told, capsys):
    assert main(["synth-top", *arguments]) == 2
    assert capsys.readouterr().err == f"gravcomp-lab synth-top: {told}\n"
