// Claim of gc_hidden_lane, for every sum: a is the sum, truncated and clipped to 18 bits.
module hidden_saturation #(
    parameter SUM_BITS = 1,
    parameter DROP = 0
) (
    input clk,
    input rst,
    input in_valid,
    input [53:0] in_x
);

  wire signed [17:0] a;
  (* hierconn *) wire [SUM_BITS-1:0] \dut.sum ;

  gc_hidden_lane dut (.clk(clk), .rst(rst), .in_valid(in_valid), .in_x(in_x), .out_a(a));

  reg seen = 0;
  reg signed [SUM_BITS-1:0] sum_1;

  always @(posedge clk) begin
    seen <= 1;
    sum_1 <= \dut.sum ;
  end

  wire signed [SUM_BITS-1:0] kept = sum_1 >>> DROP;

  always @* sums_are_clipped : assert (!seen || a == (kept < -131072 ? -131072 : kept > 131071 ? 131071 : kept));

endmodule
