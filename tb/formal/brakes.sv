// Claims of gc_brakes with all that watches brakes, for every behaviour of its inputs and of the read-back pins.
// Causes and the sequence as such: safety.sv. Parameters: codes of the states.
module brakes #(
    parameter [2:0] BRAKED = 0,
    parameter [2:0] HOLDING = 0,
    parameter [2:0] RUN = 0,
    parameter [2:0] FAULT = 0
) (
    input clk,
    input rst,
    input enable,
    input clear,
    input in_fault,
    input in_healthy,
    input in_carried,
    input [2:0] brake_fed,
    input [31:0] cfg_brake_clocks,
    input [31:0] cfg_test_clocks
);

  wire [2:0] state, brake_release, brake_engage, feedback;
  wire run, wrong, upset;
  (* hierconn *) wire \dut.pins_differ , \dut.test_failed ;

  gc_brakes dut (
      .clk(clk), .rst(rst), .enable(enable), .clear(clear), .in_fault(in_fault), .in_healthy(in_healthy),
      .in_carried(in_carried), .brake_fed(brake_fed), .cfg_brake_clocks(cfg_brake_clocks),
      .cfg_test_clocks(cfg_test_clocks), .state(state), .run(run), .brake_release(brake_release),
      .brake_engage(brake_engage), .sts_feedback(feedback), .wrong(wrong), .upset(upset)
  );

  // Brakes that are let go, and those that one path alone holds.
  wire [2:0] open = brake_release & ~brake_engage, by_one = brake_release ^ ~brake_engage;
  // Since HOLDING began: axes that were let go, that the first path held alone, that the second one did.
  reg [2:0] opened = 0, by_first = 0, by_second = 0;
  // The clock before; pins of the last two.
  reg rst_1 = 1, fault_1 = 0, seen_wrong_1 = 0;
  reg [2:0] state_1 = BRAKED, pins_1 = 0, pins_2 = 0;

  always @(posedge clk) begin
    opened <= state == HOLDING ? opened | open : 0;
    by_first <= state == HOLDING ? by_first | ~brake_release & ~brake_engage : 0;
    by_second <= state == HOLDING ? by_second | brake_release & brake_engage : 0;
    seen_wrong_1 <= !rst && (\dut.pins_differ || \dut.test_failed );
    {rst_1, fault_1, state_1, pins_1, pins_2} <= {rst, in_fault, state, brake_fed, pins_1};
  end

  always @* begin
    brakes_are_shut_but_in_run_and_test :
      assert (open == 0 || state == RUN && open == 3'b111 || state == HOLDING && (open & (open - 1)) == 0);
    both_paths_shut_the_brakes : assert (state == RUN || state == HOLDING || brake_release == 0 && brake_engage == 3'b111);
    both_paths_open_the_brakes : assert (state != RUN || brake_release == 3'b111 && brake_engage == 0);
    paths_differ_on_the_axis_in_its_test_alone : assert (by_one == 0 || state == HOLDING && (by_one & (by_one - 1)) == 0);
    each_brake_is_tested_before_all_open :
      assert (state != RUN || state_1 == RUN || (opened & by_first & by_second) == 3'b111);
    faults_shut_the_brakes : assert (!fault_1 || rst_1 || state == FAULT && brake_release == 0 && brake_engage == 3'b111);
    command_is_active_in_holding_and_run : assert (run == (state == HOLDING || state == RUN));
    pins_are_passed_on : assert (feedback == pins_2);
    what_pins_or_test_find_is_wrong_and_nothing_else : assert (wrong == seen_wrong_1);
    nothing_is_upset_of_itself : assert (!upset);
  end

endmodule
