// Claims of gc_synchronizer, for every level of its pins as they are sampled: they come out as they went in, stage by
// stage. WIDTH, STAGES: width_g, stages_g.
module synchronizer #(
    parameter WIDTH = 1,
    parameter STAGES = 2
) (
    input clk,
    input rst,
    input [WIDTH-1:0] async_data
);

  wire out_valid;
  wire [WIDTH-1:0] out_data;

  gc_synchronizer dut (
      .clk(clk), .rst(rst), .async_data(async_data), .out_valid(out_valid), .out_data(out_data)
  );

  // Samples, the newest lowest; which of them came since power-up or a reset.
  reg [WIDTH*STAGES-1:0] samples = 0;
  reg [STAGES-1:0] since = 0;

  always @(posedge clk) begin
    samples <= {samples, async_data};
    since <= rst ? 0 : {since, 1'b1};
  end

  always @* begin
    pins_come_out_after_the_stages : assert (out_data == samples[WIDTH*(STAGES-1)+:WIDTH]);
    pins_are_known_after_the_stages : assert (out_valid == since[STAGES-1]);
  end

endmodule
