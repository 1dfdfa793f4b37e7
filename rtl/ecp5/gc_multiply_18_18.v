// SPDX-License-Identifier: MIT
//
// gc_multiply at 18 x 18 bits for ECP5: one MULT18X18D with the input and the output registers inside the block, which
// Yosys does not pack by itself. Replaces the module that GHDL writes for gc_multiply_18_18; ports and clocks are those
// of rtl/gc_multiply.vhd.

module gc_multiply_18_18 (
  input         clk,
  input         rst,
  input         in_valid,
  input  [17:0] in_a,
  input  [17:0] in_b,
  output        out_valid,
  output [35:0] out_product
);

  reg valid_1 = 1'b0;
  reg valid_2 = 1'b0;

  assign out_valid = valid_2;

  always @(posedge clk) begin
    valid_1 <= in_valid & ~rst;
    valid_2 <= valid_1 & ~rst;
  end

  MULT18X18D #(
    .REG_INPUTA_CLK("CLK0"),
    .REG_INPUTB_CLK("CLK0"),
    .REG_OUTPUT_CLK("CLK0")
  ) i_block (
    .CLK0(clk), .CE0(1'b1), .RST0(1'b0),
    .SIGNEDA(1'b1), .SIGNEDB(1'b1), .SOURCEA(1'b0), .SOURCEB(1'b0),
    .A0(in_a[0]), .A1(in_a[1]), .A2(in_a[2]), .A3(in_a[3]), .A4(in_a[4]), .A5(in_a[5]),
    .A6(in_a[6]), .A7(in_a[7]), .A8(in_a[8]), .A9(in_a[9]), .A10(in_a[10]), .A11(in_a[11]),
    .A12(in_a[12]), .A13(in_a[13]), .A14(in_a[14]), .A15(in_a[15]), .A16(in_a[16]), .A17(in_a[17]),
    .B0(in_b[0]), .B1(in_b[1]), .B2(in_b[2]), .B3(in_b[3]), .B4(in_b[4]), .B5(in_b[5]),
    .B6(in_b[6]), .B7(in_b[7]), .B8(in_b[8]), .B9(in_b[9]), .B10(in_b[10]), .B11(in_b[11]),
    .B12(in_b[12]), .B13(in_b[13]), .B14(in_b[14]), .B15(in_b[15]), .B16(in_b[16]), .B17(in_b[17]),
    .P0(out_product[0]), .P1(out_product[1]), .P2(out_product[2]), .P3(out_product[3]),
    .P4(out_product[4]), .P5(out_product[5]), .P6(out_product[6]), .P7(out_product[7]),
    .P8(out_product[8]), .P9(out_product[9]), .P10(out_product[10]), .P11(out_product[11]),
    .P12(out_product[12]), .P13(out_product[13]), .P14(out_product[14]), .P15(out_product[15]),
    .P16(out_product[16]), .P17(out_product[17]), .P18(out_product[18]), .P19(out_product[19]),
    .P20(out_product[20]), .P21(out_product[21]), .P22(out_product[22]), .P23(out_product[23]),
    .P24(out_product[24]), .P25(out_product[25]), .P26(out_product[26]), .P27(out_product[27]),
    .P28(out_product[28]), .P29(out_product[29]), .P30(out_product[30]), .P31(out_product[31]),
    .P32(out_product[32]), .P33(out_product[33]), .P34(out_product[34]), .P35(out_product[35])
  );

endmodule
