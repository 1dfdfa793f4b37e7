// Claims of gc_compensator, for all forces with their friction: each is clipped to 24 bits, and flagged if so.
module force_saturation #(
    parameter TOTAL_BITS = 1
) (
    input clk,
    input rst,
    input in_valid,
    input [71:0] in_force,
    input [95:0] in_count,
    input [95:0] in_period
);

  wire [71:0] force_mn;
  wire [2:0] saturated;
  (* hierconn *) wire [TOTAL_BITS-1:0] \dut.g_unit_n1_total_13 , \dut.g_unit_n2_total_13 , \dut.g_unit_n3_total_13 ;

  gc_compensator dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_force(in_force), .in_count(in_count), .in_period(in_period),
      .out_force(force_mn), .out_saturated(saturated)
  );

  reg seen = 0;
  reg [3*TOTAL_BITS-1:0] totals;

  always @(posedge clk) begin
    seen <= 1;
    totals <= {\dut.g_unit_n3_total_13 , \dut.g_unit_n2_total_13 , \dut.g_unit_n1_total_13 };
  end

  wire [2:0] clipped, flagged;

  genvar i;
  generate
    for (i = 0; i < 3; i = i + 1) begin : g_axis
      wire signed [TOTAL_BITS-1:0] total = totals[TOTAL_BITS*i+:TOTAL_BITS];
      wire signed [TOTAL_BITS-1:0] wanted = total < -8388608 ? -8388608 : total > 8388607 ? 8388607 : total;

      assign clipped[i] = $signed(force_mn[24*i+:24]) == wanted;
      assign flagged[i] = saturated[i] == (total != wanted);
    end
  endgenerate

  always @* begin
    forces_are_clipped : assert (!seen || &clipped);
    clipped_forces_are_flagged : assert (!seen || &flagged);
  end

endmodule
