// Claims of gc_core_serial, for every behaviour of its inputs: when it answers, and what becomes of an output's sum.
module serial_core #(
    parameter LATENCY = 1,
    parameter SUM_BITS = 1,
    parameter DROP = 0
) (
    input clk,
    input rst,
    input in_valid,
    input [95:0] in_count
);

  wire in_ready, out_valid;
  wire [71:0] out_force;
  wire [2:0] out_saturated;
  (* hierconn *) wire [SUM_BITS-1:0] \dut.sum ;
  (* hierconn *) wire \dut.takes_y ;

  gc_core_serial dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_ready(in_ready), .in_count(in_count),
      .out_valid(out_valid), .out_force(out_force), .out_saturated(out_saturated)
  );

  // Clocks since counts were taken; 0 at rest.
  reg [15:0] elapsed = 0;
  reg seen = 0, due = 0, taken = 0;
  reg signed [SUM_BITS-1:0] sum;
  reg [71:0] force_1;
  reg [2:0] saturated_1;

  always @(posedge clk) begin
    seen <= 1;
    elapsed <= rst || elapsed == LATENCY - 1 ? 0 : elapsed != 0 || in_valid && in_ready ? elapsed + 1 : 0;
    due <= !rst && elapsed == LATENCY - 1;
    taken <= \dut.takes_y ;
    sum <= \dut.sum ;
    force_1 <= out_force;
    saturated_1 <= out_saturated;
  end

  wire signed [SUM_BITS-1:0] kept = sum >>> DROP;
  wire signed [SUM_BITS-1:0] wanted = kept < -131072 ? -131072 : kept > 131071 ? 131071 : kept;

  always @* begin
    result_comes_at_the_latency_and_never_else : assert (out_valid == due);
    ready_at_rest_alone : assert (in_ready == (elapsed == 0));
    // The newest is the last axis'.
    output_sum_is_clipped : assert (!seen || !taken || $signed(out_force[71:48]) == wanted);
    clipped_output_is_flagged : assert (!seen || !taken || out_saturated[2] == (kept != wanted));
    others_move_down : assert (!seen || !taken || {out_force[47:0], out_saturated[1:0]} == {force_1[71:24], saturated_1[2:1]});
    forces_hold : assert (!seen || taken || {out_force, out_saturated} == {force_1, saturated_1});
  end

endmodule
