"""Place and route of a board: pins and clock of its constraints, a packed file that holds what was placed."""

import pytest

from gravcomp.errors import InputError
from gravcomp_lab.boards.bitstream import _check_unpacked, _report
from gravcomp_lab.synthesis.place_route import CONFIG, run_nextpnr, run_tool
from gravcomp_lab.synthesis.yosys import synthesise

# A counter that begins at 0x155, so that its flip-flops differ, and a block RAM with words of its own.
BLINK = """module blink(input clk, output reg led);
  reg [8:0] count = 9'h155;
  reg [7:0] words [0:511], word;
  integer k;
  initial for (k = 0; k < 512; k = k + 1) words[k] = 37 * k + 11;
  always @(posedge clk) begin
    count <= count + 1;
    word <= words[count];
    led <= ^word;
  end
endmodule
"""
PINS = """LOCATE COMP "clk" SITE "P3";
IOBUF PORT "clk" IO_TYPE=LVCMOS33;
LOCATE COMP "led" SITE "U16";
IOBUF PORT "led" IO_TYPE=LVCMOS33;
FREQUENCY PORT "clk" {} MHZ;
"""


def placed(folder, netlist, text):
    (folder / "mine.lpf").write_text(text)
    return run_nextpnr(netlist, device="25k", package="CABGA381", speed=6, seed=1, out=folder / "out",
                       router="router2", constraints=folder / "mine.lpf")  # fmt: skip


def test_small_design_comes_out_of_its_bitstream_as_it_was_placed(tmp_path):
    (tmp_path / "blink.v").write_text(BLINK)
    netlist = synthesise(tmp_path / "blink.v", "blink", "ecp5", tmp_path).json
    report = placed(tmp_path, netlist, PINS.format(25))
    used, (clock,) = _report(report)
    assert used["TRELLIS_FF"][0] == 10
    assert used["DP16KD"][0] == 1
    assert used["TRELLIS_IO"][0] == 2
    assert (clock.asked_mhz, clock.reached_mhz > 25.0) == (25.0, True)

    out = report.parent
    run_tool("ecppack", ["--compress", "--input", CONFIG, "--bit", "board.bit"], out)
    run_tool("ecpunpack", ["--input", "board.bit", "--textcfg", "unpacked.config"], out)
    _check_unpacked(out / CONFIG, out / "unpacked.config")

    first = report.stat().st_mtime_ns
    assert placed(tmp_path, netlist, PINS.format(25)).stat().st_mtime_ns == first  # nothing changed: not repeated
    _, (clock,) = _report(placed(tmp_path, netlist, PINS.format(50)))
    assert clock.asked_mhz == 50.0
    first = report.stat().st_mtime_ns
    (out / CONFIG).unlink()
    assert placed(tmp_path, netlist, PINS.format(50)).stat().st_mtime_ns != first  # a result is gone: made again
    assert (out / CONFIG).exists()
    with pytest.raises(InputError, match="nextpnr-ecp5: "):
        placed(tmp_path, netlist, PINS.format(50).replace("U16", "ZZ99"))
    assert not (out / "options.txt").exists()  # what failed is no result
