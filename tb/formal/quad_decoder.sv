// Claims of gc_quad_decoder about its count, for every behaviour of every pin and configuration input.
//
// The reference is a table of the sixteen pairs of successive filtered levels: +1, -1, 0, or illegal.
module quad_decoder (
    input clk,
    input rst,
    input a,
    input b,
    input z,
    input cfg_home_enable,
    input [31:0] cfg_index_position,
    input cfg_clear
);

  wire count_valid, direction, speed_valid, speed_zero, referenced, illegal, glitch;
  wire [31:0] count, speed_period;
  (* hierconn *) wire [2:0] \dut.valid , \dut.level , \dut.dropped ;

  gc_quad_decoder dut (
      .clk(clk), .rst(rst), .a(a), .b(b), .z(z), .cfg_home_enable(cfg_home_enable),
      .cfg_index_position(cfg_index_position), .cfg_clear(cfg_clear), .count_valid(count_valid), .count(count),
      .direction(direction), .speed_valid(speed_valid), .speed_zero(speed_zero), .speed_period(speed_period),
      .sts_referenced(referenced), .sts_illegal(illegal), .sts_glitch(glitch)
  );

  // The clock before; bits b, a.
  reg seen = 0, rst_1 = 1, valid_1 = 0, referenced_1, illegal_1, clear_1, glitch_1, pulse_1;
  reg [31:0] count_1, plus_1, minus_1, index_position_1;
  reg [3:0] levels_1;
  reg [1:0] level_1;

  always @(posedge clk) begin
    seen <= 1;
    rst_1 <= rst;
    valid_1 <= count_valid;
    count_1 <= count;
    plus_1 <= count + 1;
    minus_1 <= count - 1;
    index_position_1 <= cfg_index_position;
    referenced_1 <= referenced;
    illegal_1 <= illegal;
    glitch_1 <= glitch;
    clear_1 <= cfg_clear;
    pulse_1 <= |\dut.dropped [1:0];
    level_1 <= \dut.level [1:0];
    levels_1 <= {level_1, \dut.level [1:0]};
  end

  wire up = levels_1 == 4'b00_01 || levels_1 == 4'b01_11 || levels_1 == 4'b11_10 || levels_1 == 4'b10_00;
  wire down = levels_1 == 4'b01_00 || levels_1 == 4'b11_01 || levels_1 == 4'b10_11 || levels_1 == 4'b00_10;
  wire both = levels_1[3] != levels_1[1] && levels_1[2] != levels_1[0];
  wire homed = referenced && !referenced_1;
  // A clock that neither starts nor ends in reset, with a count before it.
  wire follows = seen && !rst_1 && valid_1;

  always @* begin
    if (follows && !homed) begin
      moves_by_at_most_one : assert (count == count_1 || count == plus_1 || count == minus_1);
      counts_every_edge : assert (count == (up ? plus_1 : down ? minus_1 : count_1));
      direction_is_that_of_the_edge : assert (!(up || down) || direction == up);
    end
    if (follows) begin
      illegal_edge_is_flagged : assert (!both || illegal);
      illegal_edge_ends_the_reference : assert (!both || !referenced || homed);
      nothing_else_is_flagged : assert (illegal == (both || illegal_1 && !clear_1));
      dropped_pulse_is_flagged : assert (!pulse_1 || glitch);
      homing_sets_the_index_position : assert (!homed || count == index_position_1);
    end
    if (seen && rst_1) begin
      reset_clears : assert ({count_valid, count, direction, referenced, illegal, glitch, speed_valid, speed_zero} == 0);
      reset_forgets_the_speed : assert (speed_period == 32'h7fff_ffff);
    end
  end

endmodule
