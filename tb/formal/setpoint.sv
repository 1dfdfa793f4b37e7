// Claims of gc_setpoint with one axis about when it moves, for every product: whatever targets and limits are.
module setpoint (
    input clk,
    input rst,
    input run,
    input [31:0] in_count,
    input in_valid,
    input move_valid,
    input [31:0] move_target,
    input [31:0] move_ticks,
    input [31:0] cfg_speed,
    input [31:0] cfg_acceleration
);

  wire move_ready, refused;
  wire [31:0] out_setpoint, rate;

  gc_setpoint dut (
      .clk(clk), .rst(rst), .run(run), .in_count(in_count), .in_valid(in_valid), .move_valid(move_valid),
      .move_ready(move_ready), .move_target(move_target), .move_ticks(move_ticks), .cfg_speed(cfg_speed),
      .cfg_acceleration(cfg_acceleration), .out_setpoint(out_setpoint), .sts_refused(refused), .sts_rate(rate)
  );

  // The clock before; a move was taken and has not ended; ticks since it was, and what they allow.
  reg stopped_1 = 1, ready_1 = 0, taken_1 = 0, may = 0;
  reg [31:0] count_1 = 0, setpoint_1 = 0;

  always @(posedge clk) begin
    stopped_1 <= rst || !run;
    ready_1 <= move_ready;
    taken_1 <= move_valid && move_ready;
    count_1 <= in_count;
    setpoint_1 <= out_setpoint;
    may <= in_valid && !move_ready || may && out_setpoint == setpoint_1;
  end

  wire moved = out_setpoint != setpoint_1;

  always @* begin
    stopped_follows_the_count : assert (!stopped_1 || out_setpoint == count_1);
    nothing_is_taken_while_stopped : assert (run || !move_ready);
    a_move_taken_is_under_way : assert (!taken_1 || stopped_1 || !move_ready);
    at_rest_it_stays : assert (stopped_1 || !ready_1 || !moved);
    each_tick_moves_once_at_most : assert (stopped_1 || !moved || may);
  end

endmodule
