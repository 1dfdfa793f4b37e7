// Claims of gc_crossing_bus, for every behaviour of both clocks, see crossing_pulse. STAGES: stages_g; BITS: width_g.
module crossing_bus #(
    parameter STAGES = 2,
    parameter BITS = 32
) (
    input in_clk,
    input in_valid,
    input [BITS-1:0] in_data,
    input out_clk,
    input out_rst
);

  wire in_ready, out_valid;
  wire [BITS-1:0] out_data;
  (* hierconn *) wire \dut.arrives ;

  gc_crossing_bus dut (
      .in_clk(in_clk), .in_valid(in_valid), .in_ready(in_ready), .in_data(in_data), .out_clk(out_clk),
      .out_rst(out_rst), .out_valid(out_valid), .out_data(out_data)
  );

  // Words, modulo four; the last one taken; whether it was brought, or lost in a reset.
  reg [1:0] n_taken = 0, n_passed = 0;
  reg [BITS-1:0] word = 0, data_1 = 0;
  reg [3:0] n_there = 0, n_back = 0;
  reg passed_1 = 0, rst_1 = 0;

  wire [1:0] under_way = n_taken - n_passed;
  // The clock that brings a word ends its way, in reset as well.
  wire passes = \dut.arrives ;

  always @(posedge in_clk) begin
    if (in_valid && in_ready) begin
      n_taken <= n_taken + 1;
      word <= in_data;
    end
    n_back <= in_ready || under_way != 0 ? 0 : n_back <= STAGES ? n_back + 1 : n_back;
  end

  always @(posedge out_clk) begin
    if (passes) n_passed <= n_passed + 1;
    n_there <= passes || under_way == 0 ? 0 : n_there <= STAGES ? n_there + 1 : n_there;
    passed_1 <= passes;
    rst_1 <= out_rst;
    // The word, as it was taken, and since then.
    data_1 <= out_rst ? 0 : passes ? word : data_1;
  end

  always @* begin
    one_at_most_is_under_way : assert (under_way <= 1);
    none_is_taken_before_the_last_one_is_brought : assert (!in_ready || under_way == 0);
    none_invented_or_doubled : assert (!passes || under_way == 1);
    none_lost_but_in_reset : assert (out_valid == (passed_1 && !rst_1));
    brought_whole_and_held : assert (out_data == data_1);
    brought_in_time : assert (n_there <= STAGES);
    ready_again_in_time : assert (n_back <= STAGES);
  end

endmodule
