// Claims of gc_lockstep with lag_g = 1, for every pair of outputs.
module lockstep #(
    parameter BITS = 4
) (
    input clk,
    input rst,
    input [BITS-1:0] in_main,
    input [BITS-1:0] in_twin
);

  wire out_differ;

  gc_lockstep dut (.clk(clk), .rst(rst), .in_main(in_main), .in_twin(in_twin), .out_differ(out_differ));

  // The last two clocks; the first copy put out zeros before power-up.
  reg rst_1 = 1;
  reg [BITS-1:0] main_1 = 0, main_2 = 0, twin_1 = 0;

  always @(posedge clk) begin
    rst_1 <= rst;
    main_1 <= in_main;
    main_2 <= main_1;
    twin_1 <= in_twin;
  end

  always @* begin
    difference_is_seen_in_a_clock : assert (rst_1 || twin_1 == main_2 || out_differ);
    equal_copies_are_no_difference : assert (twin_1 != main_2 || !out_differ);
    reset_is_no_difference : assert (!rst_1 || !out_differ);
  end

endmodule
