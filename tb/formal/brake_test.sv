// Claims of gc_brake_test, for every behaviour of its inputs.
module brake_test (
    input clk,
    input rst,
    input in_start,
    input [2:0] in_feedback,
    input [31:0] cfg_clocks
);

  wire [2:0] first, second;
  wire done, failed, upset;
  (* hierconn *) wire \dut.ends ;

  gc_brake_test dut (
      .clk(clk), .rst(rst), .in_start(in_start), .in_feedback(in_feedback), .cfg_clocks(cfg_clocks), .out_first(first),
      .out_second(second), .out_done(done), .out_failed(failed), .upset(upset)
  );

  // The clock before; phases since the test began.
  reg going_1 = 0, ends_1 = 0, done_1 = 0;
  reg [2:0] first_1 = 0, second_1 = 0, feedback_1 = 0;
  reg [3:0] n_phases = 0;

  wire going = in_start && !rst;
  wire [5:0] switched = {first ^ first_1, second ^ second_1};
  wire [2:0] turn = first | second;

  always @(posedge clk) begin
    going_1 <= going;
    ends_1 <= \dut.ends ;
    done_1 <= done;
    first_1 <= first;
    second_1 <= second;
    feedback_1 <= in_feedback;
    n_phases <= !going ? 0 : n_phases + \dut.ends ;
  end

  always @* begin
    one_axis_at_a_time : assert ((turn & (turn - 1)) == 0);
    one_path_is_switched_at_a_time : assert (!going_1 || (switched & (switched - 1)) == 0);
    nothing_without_a_start : assert (going_1 || turn == 0 && !done && !failed);
    done_after_all_phases : assert (done == (n_phases == 12));
    every_axis_in_its_phase : assert (done || !going_1 || ends_1 || turn == 0
                                      || first == (n_phases[1:0] <= 1 ? 1 << n_phases[3:2] : 0)
                                      && second == (n_phases[1:0] == 1 || n_phases[1:0] == 2 ? 1 << n_phases[3:2] : 0));
    nothing_is_upset_of_itself : assert (!upset);
    wrong_read_back_fails : assert (failed == (going_1 && ends_1 && feedback_1 != (first_1 & second_1)));
  end

endmodule
