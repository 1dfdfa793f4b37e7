// Claims of gc_fault_latch with its guard, for every cause and every clearing. CAUSES, POSITION: bits of causes and of
// the positions of all axes.
module fault_latch #(
    parameter CAUSES = 1,
    parameter POSITION = 1
) (
    input clk,
    input rst,
    input [CAUSES-1:0] clear,
    input [CAUSES-1:0] in_fault,
    input [POSITION-1:0] in_count
);

  wire [CAUSES-1:0] fault, first_cause;
  wire [POSITION-1:0] first_count;
  wire [7:0] events;
  wire upset;

  gc_fault_latch dut (
      .clk(clk), .rst(rst), .in_clear(clear), .in_fault(in_fault), .in_count(in_count), .sts_fault(fault),
      .first_cause(first_cause), .first_count(first_count), .events(events), .upset(upset)
  );

  // The clock before.
  reg known = 0, rst_1 = 0;
  reg [CAUSES-1:0] clear_1 = 0, in_1 = 0, fault_1 = 0, first_1 = 0;
  reg [POSITION-1:0] in_count_1 = 0, count_1 = 0;
  reg [7:0] events_1 = 0;

  always @(posedge clk) begin
    {known, rst_1, clear_1, in_1, in_count_1} <= {1'b1, rst, clear, in_fault, in_count};
    {fault_1, first_1, count_1, events_1} <= {fault, first_cause, first_count, events};
  end

  wire begins = fault_1 == 0 && in_1 != 0, comes = (in_1 & ~fault_1) != 0;

  always @* begin
    latch_forgets_what_is_cleared_alone :
    assert (fault == (rst_1 ? 0 : fault_1 & ~clear_1 | in_1));
    latch_tells_the_causes_of_the_first_clock :
    assert (first_cause == (fault == 0 ? 0 : begins ? in_1 : first_1));
    latch_tells_the_position_of_the_first_clock :
    assert (first_count == (rst_1 ? 0 : begins ? in_count_1 : count_1));
    latch_counts_the_clocks_that_bring_a_cause :
    assert (!known || events == (rst_1 ? 8'd0 : events_1 + {7'd0, comes}));
    latch_is_not_upset_of_itself : assert (!upset);
  end

endmodule
