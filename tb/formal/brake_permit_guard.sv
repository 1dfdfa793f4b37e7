// Claim of gc_brake_permit with its guard, for every behaviour of its inputs: what brake_permit leaves out.
module brake_permit_guard (
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

  wire upset;

  gc_brake_permit dut (
      .clk(clk), .rst(rst), .enable(enable), .clear(clear), .in_fault(in_fault), .in_healthy(in_healthy),
      .in_carried(in_carried), .in_tested(in_tested), .in_test(in_test), .cfg_brake_clocks(cfg_brake_clocks),
      .upset(upset)
  );

  always @* permit_is_not_upset_of_itself : assert (!upset);

endmodule
