// Claims of gc_phase: the halves of the count and the parts of the steps make up the whole; results come in time.
module phase #(
    parameter LATENCY = 6
) (
    input clk,
    input rst,
    input in_valid,
    input [31:0] in_count,
    input [34:0] coarse_step,
    input [34:0] fine_step
);

  wire out_valid;
  (* hierconn *) wire [35:0] \dut.half ;
  (* hierconn *) wire [17:0] \dut.g_half_n1_g_part_n1_part , \dut.g_half_n1_g_part_n2_part ;
  (* hierconn *) wire [17:0] \dut.g_half_n2_g_part_n1_part , \dut.g_half_n2_g_part_n2_part ;

  gc_phase dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_count(in_count), .coarse_step(coarse_step),
      .fine_step(fine_step), .out_valid(out_valid)
  );

  // Bit k: a count came k clocks ago, and no reset since.
  reg [LATENCY:1] taken = 0;

  always @(posedge clk) taken <= rst ? 0 : {taken, in_valid};

  always @* begin
    none_lost : assert (!taken[LATENCY] || out_valid);
    none_invented : assert (!out_valid || taken[LATENCY]);
    halves_make_the_count :
      assert (\dut.half == {{2{in_count[31]}}, in_count[31:16], 2'b00, in_count[15:0]});
    parts_make_the_fine_step :
      assert ({\dut.g_half_n1_g_part_n2_part , \dut.g_half_n1_g_part_n1_part }
              == {fine_step[34:17], 1'b0, fine_step[16:0]});
    parts_make_the_coarse_step :
      assert ({\dut.g_half_n2_g_part_n2_part , \dut.g_half_n2_g_part_n1_part }
              == {coarse_step[34:17], 1'b0, coarse_step[16:0]});
  end

endmodule
