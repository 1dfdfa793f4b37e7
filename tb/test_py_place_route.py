"""Place and route of a board: pins and clocks of its constraints, a packed file that holds what was placed."""

from dataclasses import replace

import pytest

from gravcomp.errors import InputError
from gravcomp_lab.boards.bitstream import FAMILIES, _check_clocks, _report
from gravcomp_lab.boards.board import boards
from gravcomp_lab.synthesis.place_route import run_tool
from gravcomp_lab.synthesis.yosys import synthesise
from runner import ROOT

BOARDS = boards(ROOT / "boards")

# Of a board's nets and ports, a few: a counter on each clock that begins at 0x155, so that its flip-flops differ, a
# block RAM with words of its own, and a port per axis of a machine of one.
SMALL = """module small(input {clock}, input estop_n, input [0:0] enc_a, output drive_on);
  gc_board i_board(.clk_osc({clock}), .in(enc_a[0] ^ estop_n), .out(drive_on));
endmodule
module gc_board(input clk_osc, input in, output reg out);
  wire clk, locked;
  gc_pll i_pll(.clk_in(clk_osc), .clk_out(clk), .locked(locked));
  reg [8:0] slow = 9'h155, count = 9'h155;
  reg [7:0] words [0:511], word;
  integer k;
  initial for (k = 0; k < 512; k = k + 1) words[k] = 37 * k + 11;
  always @(posedge clk_osc) slow <= slow + 1;
  always @(posedge clk) begin
    count <= count + in;
    word <= words[count];
    out <= ^word ^ locked ^ slow[8];
  end
endmodule
"""
# Flip-flops, block RAMs, pins and PLLs as nextpnr calls them.
CELLS = {"ecp5": ("TRELLIS_FF", "DP16KD", "TRELLIS_IO", "EHXPLLL"), "gowin": ("DFF", "BSRAM", "IOB", "rPLL")}


def small(board, folder):
    """Netlist of the small design for a board."""
    clock = f"clk_{board.oscillator_hz // 1_000_000}mhz"
    (folder / "small.v").write_text(SMALL.format(clock=clock))
    return synthesise(folder / "small.v", "small", FAMILIES[board.family].target, folder, mapping=board.primitives)


# Seconds for nextpnr-ecp5; nextpnr-himbaechel takes a minute before it begins to place.
@pytest.mark.parametrize("name", ["ulx3s-25f", pytest.param("tang-nano-20k", marks=pytest.mark.slow)])
def test_small_design_comes_out_of_its_bitstream_as_it_was_placed(name, tmp_path):
    board, out = BOARDS[name], tmp_path / "out"
    family = FAMILIES[board.family]
    used, clocks = _report(family.place(board, small(board, tmp_path), 1, out))
    _check_clocks(board, clocks, out)
    assert [used[cell][0] for cell in CELLS[board.family]] == [19, 1, 4, 1]
    family.pack(board, "board", out)
    family.compare(board, "board", out)


def test_run_is_repeated_only_where_something_changed(tmp_path):
    board, out = BOARDS["ulx3s-25f"], tmp_path / "out"
    place = FAMILIES[board.family].place
    netlist = small(board, tmp_path)

    def with_pins(old: str, new: str):
        (tmp_path / "mine.lpf").write_text(board.constraints.read_text().replace(old, new))
        return replace(board, constraints=tmp_path / "mine.lpf")

    report = place(board, netlist, 1, out)
    first = report.stat().st_mtime_ns
    assert place(board, netlist, 1, out).stat().st_mtime_ns == first  # nothing changed: not repeated
    faster = with_pins("25 MHZ", "50 MHZ")
    _, clocks = _report(place(faster, netlist, 1, out))
    assert sorted(clock.asked_mhz for clock in clocks) == [50.0, 80.0]
    with pytest.raises(InputError, match=r"clocks of 50.0, 80.0 MHz were timed, ulx3s-25f runs at 25.0, 40.0"):
        _check_clocks(board, clocks, out)
    first = report.stat().st_mtime_ns
    (out / "placed.config").unlink()
    assert place(faster, netlist, 1, out).stat().st_mtime_ns != first  # a result is gone: made again
    assert (out / "placed.config").exists()
    with pytest.raises(InputError, match=r"nextpnr-ecp5: IO pin 'clk_25mhz.*' constrained to pin 'ZZ99', which does"):
        place(with_pins("G2", "ZZ99"), netlist, 1, out)
    assert not (out / "options.txt").exists()  # what failed is no result


def test_tool_that_fails_is_quoted_with_the_cause(tmp_path):
    """A tool of Python's ends its messages with the exception; nextpnr's cause is looked at above."""
    with pytest.raises(InputError, match=r"gowin_pack: .*No such file.*absent.json.*; see "):
        run_tool("gowin_pack", ["-d", "GW2A-18C", "-o", "board.fs", "absent.json"], tmp_path)
