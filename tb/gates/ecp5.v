// SPDX-License-Identifier: MIT
//
// Functional models of the ECP5 primitives in the netlists of the core: Yosys' own do not parse in Icarus, and it has
// none of MULT18X18D. Only what those netlists use; a parameter with another value stops the simulation.

module LUT4 (input A, B, C, D, output Z);

  parameter [15:0] INIT = 16'h0000;

  assign Z = INIT[{D, C, B, A}];

endmodule

module PFUMX (input ALUT, BLUT, C0, output Z);

  assign Z = C0 ? ALUT : BLUT;

endmodule

module L6MUX21 (input D0, D1, SD, output Z);

  assign Z = SD ? D1 : D0;

endmodule

// Two bits of a carry chain: each table gives the propagate bit, its lowest four entries the carry that it generates.
module CCU2C (input CIN, A0, B0, C0, D0, A1, B1, C1, D1, output S0, S1, COUT);

  parameter [15:0] INIT0 = 16'h0000;
  parameter [15:0] INIT1 = 16'h0000;
  parameter INJECT1_0 = "YES";
  parameter INJECT1_1 = "YES";

  wire propagate_0 = INIT0[{D0, C0, B0, A0}];
  wire propagate_1 = INIT1[{D1, C1, B1, A1}];
  wire carry = propagate_0 ? CIN : INIT0[{2'b00, B0, A0}];

  assign S0 = propagate_0 ^ CIN;
  assign S1 = propagate_1 ^ carry;
  assign COUT = propagate_1 ? carry : INIT1[{2'b00, B1, A1}];

  initial
    if (INJECT1_0 != "NO" || INJECT1_1 != "NO") $fatal(1, "CCU2C: this INJECT1 has no model");

endmodule

// Synchronous set or reset, which rules over the enable.
module TRELLIS_FF (input CLK, LSR, CE, DI, output reg Q);

  parameter GSR = "ENABLED";
  parameter CEMUX = "1";
  parameter CLKMUX = "CLK";
  parameter LSRMUX = "LSR";
  parameter SRMODE = "LSR_OVER_CE";
  parameter REGSET = "RESET";

  localparam set_value_c = REGSET == "SET";

  initial begin
    Q = set_value_c;
    if (CLKMUX != "CLK" || LSRMUX != "LSR" || SRMODE != "LSR_OVER_CE" || (CEMUX != "1" && CEMUX != "CE" && CEMUX != "INV"))
      $fatal(1, "TRELLIS_FF: these parameters have no model");
  end

  always @(posedge CLK)
    if (LSR) Q <= set_value_c;
    else if (CEMUX == "1" || CE == (CEMUX == "CE")) Q <= DI;

endmodule

// 18 x 18 bits, with or without registers at inputs and output; one clock, no reset.
module MULT18X18D (
  input A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, A12, A13, A14, A15, A16, A17,
  input B0, B1, B2, B3, B4, B5, B6, B7, B8, B9, B10, B11, B12, B13, B14, B15, B16, B17,
  input C0, C1, C2, C3, C4, C5, C6, C7, C8, C9, C10, C11, C12, C13, C14, C15, C16, C17,
  input SIGNEDA, SIGNEDB, SOURCEA, SOURCEB, CLK0, CLK1, CLK2, CLK3, CE0, CE1, CE2, CE3, RST0, RST1, RST2, RST3,
  output P0, P1, P2, P3, P4, P5, P6, P7, P8, P9, P10, P11, P12, P13, P14, P15, P16, P17,
  output P18, P19, P20, P21, P22, P23, P24, P25, P26, P27, P28, P29, P30, P31, P32, P33, P34, P35
);

  parameter REG_INPUTA_CLK = "NONE";
  parameter REG_INPUTA_CE = "CE0";
  parameter REG_INPUTB_CLK = "NONE";
  parameter REG_INPUTB_CE = "CE0";
  parameter REG_OUTPUT_CLK = "NONE";
  parameter REG_OUTPUT_CE = "CE0";

  wire [17:0] in_a = {A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0};
  wire [17:0] in_b = {B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0};
  reg  [17:0] a_1, b_1;
  reg  [35:0] product_1;

  wire [17:0] a = REG_INPUTA_CLK == "NONE" ? in_a : a_1;
  wire [17:0] b = REG_INPUTB_CLK == "NONE" ? in_b : b_1;
  wire [35:0] product = $signed({SIGNEDA & a[17], a}) * $signed({SIGNEDB & b[17], b});

  assign {P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18,
          P17, P16, P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0}
       = REG_OUTPUT_CLK == "NONE" ? product : product_1;

  always @(posedge CLK0) begin
    if (REG_INPUTA_CE == "CE0" ? CE0 : CE1) a_1 <= in_a;
    if (REG_INPUTB_CE == "CE0" ? CE0 : CE1) b_1 <= in_b;
    if (REG_OUTPUT_CE == "CE0" ? CE0 : CE1) product_1 <= product;
    if (RST0 === 1'b1) $fatal(1, "MULT18X18D: a reset has no model");
  end

  initial
    if ((REG_INPUTA_CLK != "NONE" && REG_INPUTA_CLK != "CLK0") || (REG_INPUTB_CLK != "NONE" && REG_INPUTB_CLK != "CLK0")
        || (REG_OUTPUT_CLK != "NONE" && REG_OUTPUT_CLK != "CLK0")
        || (REG_INPUTA_CE != "CE0" && REG_INPUTA_CE != "CE1") || (REG_INPUTB_CE != "CE0" && REG_INPUTB_CE != "CE1")
        || (REG_OUTPUT_CE != "CE0" && REG_OUTPUT_CE != "CE1"))
      $fatal(1, "MULT18X18D: these parameters have no model");

endmodule
