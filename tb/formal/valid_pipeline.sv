// Claims of gc_core about its handshake, for every behaviour of in_valid and rst.
//
// LATENCY, INTERVAL: clocks from accepted counts to their result, and between two acceptances.
// LATENCY = 0 claims that no result ever comes: the shortest run against it tells the latency.
module valid_pipeline #(
    parameter LATENCY = 0,
    parameter INTERVAL = 1
) (
    input clk,
    input rst,
    input in_valid,
    input [95:0] in_count
);

  wire in_ready, out_valid;

  gc_core dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_ready(in_ready), .in_count(in_count), .out_valid(out_valid)
  );

  generate
    if (LATENCY == 0) begin
      always @* no_result : assert (!out_valid);
    end else begin
      // Bit k: counts were accepted k clocks ago, and no reset since.
      reg [LATENCY:1] taken = 0;

      always @(posedge clk) taken <= rst ? 0 : {taken, in_valid && in_ready};

      always @* begin
        none_lost : assert (!taken[LATENCY] || out_valid);
        none_invented : assert (!out_valid || taken[LATENCY]);
      end

      if (INTERVAL == 1) begin
        always @* always_ready : assert (in_ready);
      end else begin
        always @* ready_after_the_interval : assert (in_ready == !(|taken[INTERVAL-1:1]));
      end
    end
  endgenerate

endmodule
