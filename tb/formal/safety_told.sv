// Claims of gc_safety about what it tells beside its causes, for every behaviour of its inputs: the read-back of brakes,
// and where the first cause came.
module safety_told (
    input clk,
    input rst,
    input [16:0] clear,
    input [95:0] in_count,
    input [2:0] brake_fed
);

  wire [16:0] fault;
  wire [95:0] first_count;
  wire [2:0] feedback;

  gc_safety dut (
      .clk(clk), .rst(rst), .clear(clear), .in_count(in_count), .brake_fed(brake_fed), .sts_feedback(feedback),
      .sts_fault(fault), .sts_first_count(first_count)
  );

  // The clocks before.
  reg rst_1 = 0, faulty_1 = 0;
  reg [95:0] in_count_1 = 0, in_count_2 = 0, first_1 = 0;
  reg [2:0] fed_1 = 0, fed_2 = 0;

  always @(posedge clk) begin
    {rst_1, faulty_1, first_1} <= {rst, fault != 0, first_count};
    {in_count_1, in_count_2} <= {in_count, in_count_1};
    {fed_1, fed_2} <= {brake_fed, fed_1};
  end

  wire begins = !faulty_1 && fault != 0;

  always @* begin
    read_back_is_told_two_clocks_later : assert (feedback == fed_2);
    position_is_that_of_the_first_cause : assert (!begins || first_count == in_count_2);
    position_is_kept_till_the_next_first_cause : assert (begins || first_count == (rst_1 ? 0 : first_1));
  end

endmodule
