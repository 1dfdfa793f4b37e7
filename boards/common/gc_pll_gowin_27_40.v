// SPDX-License-Identifier: MIT
//
// 27 MHz to 40 MHz: 27 / 9 * 40 / 3, from a VCO of 960 MHz: the phases are compared at 3 MHz, the least that a GW2A does.
module gc_pll (
    input  clk_in,
    output clk_out,
    output locked
);

  rPLL #(
      .DEVICE("GW2AR-18C"),
      .FCLKIN("27"),
      .IDIV_SEL(8),
      .FBDIV_SEL(39),
      .ODIV_SEL(8),
      .CLKFB_SEL("internal"),
      .CLKOUTD3_SRC("CLKOUT"),
      .CLKOUT_BYPASS("false"),
      .CLKOUTP_BYPASS("false"),
      .CLKOUTD_BYPASS("false"),
      .DYN_IDIV_SEL("false"),
      .DYN_FBDIV_SEL("false"),
      .DYN_ODIV_SEL("false"),
      .DYN_SDIV_SEL(2),
      .PSDA_SEL("0000"),
      .DUTYDA_SEL("1000"),
      .DYN_DA_EN("false")
  ) pll (
      .CLKIN(clk_in),
      .CLKFB(1'b0),
      .CLKOUTD3(clk_out),
      .LOCK(locked),
      .RESET(1'b0),
      .RESET_P(1'b0),
      .FBDSEL(6'd0),
      .IDSEL(6'd0),
      .ODSEL(6'd0),
      .PSDA(4'd0),
      .DUTYDA(4'd0),
      .FDLY(4'd0)
  );

endmodule
