// Claims of gc_brake_sequencer with its guard, for every behaviour of its inputs: the arrows of its diagram, and what
// each state is to brakes and command. The codes of its states are parameters.
module brake_sequencer #(
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
    input in_tested,
    input [2:0] in_test,
    input [31:0] cfg_brake_clocks
);

  wire [2:0] state, brake_release;
  wire run, may_test, upset;

  gc_brake_sequencer dut (
      .clk(clk), .rst(rst), .enable(enable), .clear(clear), .in_fault(in_fault), .in_healthy(in_healthy),
      .in_carried(in_carried), .in_tested(in_tested), .in_test(in_test), .cfg_brake_clocks(cfg_brake_clocks),
      .state(state), .run(run), .may_test(may_test), .brake_release(brake_release), .upset(upset)
  );

  // The clocks before; enable counts as high before power-up.
  reg enable_1 = 1, enable_2 = 1, rst_1 = 1, clear_1 = 0, fault_1 = 0, healthy_1 = 0, tested_1 = 0, may_1 = 0;
  reg [2:0] state_1 = BRAKED, test_1 = 0;

  always @(posedge clk) begin
    {enable_1, enable_2} <= {enable, enable_1};
    {rst_1, clear_1, fault_1, healthy_1, tested_1} <= {rst, clear, in_fault, in_healthy, in_tested};
    {may_1, test_1, state_1} <= {may_test, in_test, state};
  end

  wire quiet_1 = !rst_1 && !fault_1;

  always @* begin
    sequencer_has_four_states : assert (state == BRAKED || state == HOLDING || state == RUN || state == FAULT);
    sequencer_is_braked_by_reset : assert (!rst_1 || state == BRAKED);
    sequencer_ends_all_in_a_fault : assert (rst_1 || !fault_1 || state == FAULT);
    sequencer_leaves_a_fault_when_cleared : assert (!quiet_1 || state_1 != FAULT || state == (clear_1 ? BRAKED : FAULT));
    sequencer_starts_by_an_edge_while_healthy :
    assert (!quiet_1 || state_1 != BRAKED || state == (enable_1 && !enable_2 && healthy_1 ? HOLDING : BRAKED));
    sequencer_runs_when_the_load_is_carried_and_the_test_over :
    assert (!quiet_1 || state_1 != HOLDING || !enable_1 || state == (may_1 && tested_1 ? RUN : HOLDING));
    sequencer_holds_till_the_brakes_close :
    assert (!quiet_1 || state_1 != HOLDING || enable_1 || state == HOLDING || state == BRAKED && !enable_2);
    sequencer_stops_by_holding : assert (!quiet_1 || state_1 != RUN || state == (enable_1 ? RUN : HOLDING));
    sequencer_commands_in_holding_and_run : assert (run == (state == HOLDING || state == RUN));
    sequencer_releases_in_run_and_test :
    assert (brake_release == (state == RUN ? 3'b111 : state == HOLDING ? test_1 : 3'b000));
    sequencer_tests_a_carried_load_alone : assert (!may_test || state == HOLDING && enable && enable_1 && in_carried);
    sequencer_is_not_upset_of_itself : assert (!upset);
  end

endmodule
