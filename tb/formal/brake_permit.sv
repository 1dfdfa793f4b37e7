// Claims of gc_brake_permit, for every behaviour of its inputs. That it agrees with gc_brake_sequencer: safety.sv.
module brake_permit (
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

  wire faulty, idle, shut;
  wire [2:0] brake_engage;

  gc_brake_permit dut (
      .clk(clk), .rst(rst), .enable(enable), .clear(clear), .in_fault(in_fault), .in_healthy(in_healthy),
      .in_carried(in_carried), .in_tested(in_tested), .in_test(in_test), .cfg_brake_clocks(cfg_brake_clocks),
      .faulty(faulty), .idle(idle), .shut(shut), .brake_engage(brake_engage)
  );

  // The clocks before; enable counts as high before power-up.
  reg rst_1 = 1, enable_1 = 1, enable_2 = 1, clear_1 = 0, fault_1 = 0, healthy_1 = 0, carried_1 = 0, tested_1 = 0;
  reg faulty_1 = 0, idle_1 = 1, shut_1 = 1;
  reg [2:0] test_1 = 0;

  always @(posedge clk) begin
    rst_1 <= rst;
    {enable_1, enable_2} <= {enable, enable_1};
    {clear_1, fault_1, healthy_1, carried_1, tested_1, test_1} <= {clear, in_fault, in_healthy, in_carried, in_tested, in_test};
    {faulty_1, idle_1, shut_1} <= {faulty, idle, shut};
  end

  always @* begin
    flags_do_not_contradict : assert ((shut || !idle) && (idle || !faulty));
    brakes_are_engaged_but_in_run_and_test : assert (brake_engage == (idle ? 3'b111 : shut ? ~test_1 : 3'b000));
    faults_engage_the_brakes : assert (!fault_1 || rst_1 || faulty && idle && shut);
    faulty_until_cleared : assert (!faulty_1 || faulty || rst_1 || clear_1 && !fault_1);
    faulty_by_a_fault : assert (!faulty || faulty_1 || fault_1);
    motion_starts_by_an_edge_while_healthy :
      assert (idle || !idle_1 || enable_1 && !enable_2 && healthy_1 && !faulty_1 && !fault_1);
    brakes_open_after_the_load_is_carried_and_the_test :
      assert (shut || !shut_1 || !idle_1 && enable_1 && carried_1 && tested_1 && !fault_1);
    command_ends_behind_closed_brakes : assert (!idle || idle_1 || faulty || rst_1 || shut_1 && !enable_1);
    reset_engages_the_brakes : assert (!rst_1 || !faulty && idle && shut);
  end

endmodule
