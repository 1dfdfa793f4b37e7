// SPDX-License-Identifier: MIT
//
// 25 MHz to 40 MHz: 25 * 32 / 20, of a VCO at 800 MHz. Never run.
module gc_pll (
    input  clk_in,
    output clk_out,
    output locked
);

  wire feedback;
  wire divided;

  MMCME2_BASE #(
      .CLKIN1_PERIOD(40.0),
      .CLKFBOUT_MULT_F(32.0),
      .DIVCLK_DIVIDE(1),
      .CLKOUT0_DIVIDE_F(20.0)
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
