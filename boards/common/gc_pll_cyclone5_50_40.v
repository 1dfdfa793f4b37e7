// SPDX-License-Identifier: MIT
//
// 50 MHz to 40 MHz. Never run.
module gc_pll (
    input  clk_in,
    output clk_out,
    output locked
);

  altera_pll #(
      .fractional_vco_multiplier("false"),
      .reference_clock_frequency("50.0 MHz"),
      .operation_mode("direct"),
      .number_of_clocks(1),
      .output_clock_frequency0("40.000000 MHz"),
      .phase_shift0("0 ps"),
      .duty_cycle0(50)
  ) pll (
      .refclk(clk_in),
      .rst(1'b0),
      .outclk(clk_out),
      .locked(locked),
      .fboutclk(),
      .fbclk(1'b0)
  );

endmodule
