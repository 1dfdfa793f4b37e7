// Claims of gc_output_scaler, for all output sums: y is each sum, truncated and clipped to 18 bits, and flagged if so.
module output_saturation #(
    parameter SUM_BITS = 1,
    parameter DROP = 0
) (
    input clk,
    input rst,
    input in_valid,
    input [3*SUM_BITS-1:0] in_total
);

  (* hierconn *) wire [53:0] \dut.y_1 ;
  (* hierconn *) wire [2:0] \dut.saturated_1 ;

  gc_output_scaler dut (.clk(clk), .rst(rst), .in_valid(in_valid), .in_total(in_total));

  // The last sums that came.
  reg seen = 0;
  reg [3*SUM_BITS-1:0] total;

  always @(posedge clk) if (in_valid) {seen, total} <= {1'b1, in_total};

  wire [2:0] clipped, flagged;

  genvar i;
  generate
    for (i = 0; i < 3; i = i + 1) begin : g_axis
      wire signed [SUM_BITS-1:0] sum = total[SUM_BITS*i+:SUM_BITS];
      wire signed [SUM_BITS-1:0] kept = sum >>> DROP;
      wire signed [SUM_BITS-1:0] wanted = kept < -131072 ? -131072 : kept > 131071 ? 131071 : kept;

      assign clipped[i] = $signed(\dut.y_1 [18*i+:18]) == wanted;
      assign flagged[i] = \dut.saturated_1 [i] == (kept != wanted);
    end
  endgenerate

  always @* begin
    sums_are_clipped : assert (!seen || &clipped);
    clipped_sums_are_flagged : assert (!seen || &flagged);
  end

endmodule
