// SPDX-License-Identifier: MIT
//
// 100 MHz to 25 MHz: 100 * 8 / 32, of a VCO at 800 MHz. Never run.
module gc_clock_100_25 (
    input  clk_in,
    output clk_out,
    output locked
);

  wire feedback;
  wire divided;

  MMCME2_BASE #(
      .CLKIN1_PERIOD(10.0),
      .CLKFBOUT_MULT_F(8.0),
      .DIVCLK_DIVIDE(1),
      .CLKOUT0_DIVIDE_F(32.0)
  ) mmcm (
      .CLKIN1(clk_in),
      .CLKFBIN(feedback),
      .CLKFBOUT(feedback),
      .CLKOUT0(divided),
      .LOCKED(locked),
      .PWRDWN(1'b0),
      .RST(1'b0)
  );

  BUFG buffer (
      .I(divided),
      .O(clk_out)
  );

endmodule
