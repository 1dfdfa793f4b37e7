// SPDX-License-Identifier: MIT
//
// 25 MHz to 40 MHz: 25 / 5 * 8, from a VCO of 600 MHz.
module gc_pll (
    input  clk_in,
    output clk_out,
    output locked
);

  (* FREQUENCY_PIN_CLKI = "25", FREQUENCY_PIN_CLKOP = "40" *)
  EHXPLLL #(
      .PLLRST_ENA("DISABLED"),
      .INTFB_WAKE("DISABLED"),
      .STDBY_ENABLE("DISABLED"),
      .DPHASE_SOURCE("DISABLED"),
      .OUTDIVIDER_MUXA("DIVA"),
      .CLKOP_ENABLE("ENABLED"),
      .CLKI_DIV(5),
      .CLKFB_DIV(8),
      .CLKOP_DIV(15),
      .CLKOP_CPHASE(7),
      .CLKOP_FPHASE(0),
      .FEEDBK_PATH("CLKOP")
  ) pll (
      .CLKI(clk_in),
      .CLKFB(clk_out),
      .CLKOP(clk_out),
      .LOCK(locked),
      .RST(1'b0),
      .STDBY(1'b0),
      .PHASESEL0(1'b0),
      .PHASESEL1(1'b0),
      .PHASEDIR(1'b1),
      .PHASESTEP(1'b1),
      .PHASELOADREG(1'b1),
      .PLLWAKESYNC(1'b0),
      .ENCLKOP(1'b0)
  );

endmodule
