// Claims of gc_parity_guard, for every word that is loaded and every set of wrong bits. BITS: width_g.
module parity_guard #(
    parameter BITS = 32
) (
    input clk,
    input rst,
    input in_load,
    input [BITS-1:0] in_next,
    input [BITS-1:0] wrong
);

  wire out_parity, out_upset;

  // The registers that are guarded.
  reg [BITS-1:0] held = 0;
  // The clock before.
  reg rst_1 = 1;
  reg [BITS-1:0] wrong_1 = 0;

  gc_parity_guard dut (
      .clk(clk), .rst(rst), .in_load(in_load), .in_next(in_next), .in_word(held ^ wrong), .out_parity(out_parity),
      .out_upset(out_upset)
  );

  always @(posedge clk) begin
    if (in_load) held <= in_next;
    rst_1 <= rst;
    wrong_1 <= wrong;
  end

  always @* begin
    single_wrong_bit_is_found : assert (rst_1 || wrong_1 == 0 || (wrong_1 & (wrong_1 - 1)) != 0 || out_upset);
    nothing_else_is : assert (wrong_1 != 0 || !out_upset);
    reset_forgets : assert (!rst_1 || !out_upset);
    parity_goes_along : assert (out_parity == ^(in_load ? in_next : held));
  end

endmodule
