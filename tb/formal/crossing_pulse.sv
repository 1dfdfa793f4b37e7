// Claims of gc_crossing_pulse, for every behaviour of both clocks: each is a free level, so that its edges fall in any
// order, together, or never. A synchroniser that samples a level while it changes takes either value; so it does here,
// as its edge may come before or after that of the level. STAGES: stages_g.
module crossing_pulse #(
    parameter STAGES = 2
) (
    input in_clk,
    input in_valid,
    input out_clk
);

  wire in_ready, out_valid;

  gc_crossing_pulse dut (
      .in_clk(in_clk), .in_valid(in_valid), .in_ready(in_ready), .out_clk(out_clk), .out_valid(out_valid)
  );

  // Pulses, modulo four.
  reg [1:0] n_taken = 0, n_brought = 0;
  // Edges of out_clk since a pulse was taken, of in_clk since it was brought; both stop at STAGES + 1.
  reg [3:0] n_there = 0, n_back = 0;

  wire [1:0] under_way = n_taken - n_brought;

  always @(posedge in_clk) begin
    if (in_valid && in_ready) n_taken <= n_taken + 1;
    n_back <= in_ready || under_way != 0 ? 0 : n_back <= STAGES ? n_back + 1 : n_back;
  end

  always @(posedge out_clk) begin
    if (out_valid) n_brought <= n_brought + 1;
    n_there <= out_valid || under_way == 0 ? 0 : n_there <= STAGES ? n_there + 1 : n_there;
  end

  always @* begin
    none_invented_or_doubled : assert (!out_valid || under_way == 1);
    one_at_most_is_under_way : assert (under_way <= 1);
    none_is_taken_before_the_last_one_is_brought : assert (!in_ready || under_way == 0);
    brought_in_time : assert (n_there <= STAGES);
    ready_again_in_time : assert (n_back <= STAGES);
  end

endmodule
