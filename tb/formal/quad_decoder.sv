// Claims of gc_quad_decoder about its count, for every behaviour of every pin and configuration input.
//
// The reference is a table of the sixteen pairs of successive levels: +1, -1, 0, or both changed. Applied to the levels
// that the filters let through, it is what count must do. Applied to all samples, short levels included, it is what the
// encoder did. From any clock on in which samples and levels agree (start), whenever they agree again, the counts of the
// two are equal or sts_illegal was set in between (lost_counts_are_told); and gc_count_check tells of nothing else.
// Samples that change at once, which are two counts of unknown direction, are taken back by the next that do. If before
// that samples and levels agree, a level changes, or one is four counts ahead, that is lost counts, too.
// SAMPLES: filter_samples_g.
module quad_decoder #(
    parameter SAMPLES = 4
) (
    input clk,
    input rst,
    input a,
    input b,
    input z,
    input error,
    input cfg_home_enable,
    input [31:0] cfg_index_position,
    input [31:0] cfg_index_period,
    input cfg_clear,
    input start
);

  wire count_valid, direction, speed_valid, speed_zero, referenced, illegal, glitch;
  wire [31:0] count, speed_period;
  (* hierconn *) wire [2:0] \dut.valid , \dut.level , \dut.dropped ;
  (* hierconn *) wire \dut.lost_cycle , \dut.lost_index , \dut.broken , \dut.step_valid , \dut.step_illegal , \dut.z_1 ;

  gc_quad_decoder dut (
      .clk(clk), .rst(rst), .a(a), .b(b), .z(z), .error(error), .cfg_home_enable(cfg_home_enable),
      .cfg_index_position(cfg_index_position), .cfg_index_period(cfg_index_period), .cfg_clear(cfg_clear),
      .count_valid(count_valid), .count(count), .direction(direction), .speed_valid(speed_valid),
      .speed_zero(speed_zero), .speed_period(speed_period), .sts_referenced(referenced), .sts_illegal(illegal),
      .sts_glitch(glitch)
  );

  localparam [2:0] UP = 1, DOWN = -1, BOTH = 2;

  function [2:0] step(input [1:0] before, input [1:0] after);  // bits b, a
    case ({before, after})
      4'b00_01, 4'b01_11, 4'b11_10, 4'b10_00: step = UP;
      4'b01_00, 4'b11_01, 4'b10_11, 4'b00_10: step = DOWN;
      4'b00_11, 4'b11_00, 4'b01_10, 4'b10_01: step = BOTH;
      default: step = 0;
    endcase
  endfunction

  function [5:0] counts(input [2:0] of);
    counts = of == UP ? 1 : of == DOWN ? -1 : 0;
  endfunction

  // Pins as the filters have taken them in: two clocks of the synchroniser, one of a filter.
  reg [1:0] pins_1 = 0, pins_2 = 0, pins_3 = 0, sample_1 = 0;
  reg error_1 = 0, error_2 = 0, error_3 = 0;
  reg [1:0] out_of_reset = 0;
  wire [1:0] sample = SAMPLES == 0 ? pins_2 : pins_3;
  wire [1:0] level = \dut.level [1:0];

  // The clock before.
  reg seen = 0, rst_1 = 1, valid_1 = 0, referenced_1, illegal_1, clear_1, pulse_1, told_1 = 0;
  reg [31:0] count_1, plus_1, minus_1, index_position_1;
  reg [1:0] level_1;
  reg [2:0] passed_1;

  wire [2:0] sampled = step(sample_1, sample);
  wire [2:0] passed = step(level_1, level);

  // From start on: counts of the samples less those of the levels, whether samples changed at once and not back, and
  // whether that became lost counts; whether anything was told.
  reg watched = 0, both = 0, lost = 0, lost_1 = 0, lost_2 = 0, watched_1 = 0, watched_2 = 0, told = 0;
  reg [5:0] ahead = 0;
  wire agree = sample == level;
  wire [5:0] ahead_now = ahead + counts(sampled) - counts(passed);
  wire both_now = both ^ (sampled == BOTH);
  wire four = ahead_now == 4 || ahead_now == -6'd4;
  wire lost_now = watched && (lost || passed == BOTH || both_now && (passed != 0 || four) || agree && (both_now || ahead_now != 0));
  wire restart = rst || !count_valid || start && agree;

  // Homing: z = '0' was seen in the index phase since it began.
  reg enable_1 = 0, low = 0, low_1 = 0;

  // An index whose filter knows its level, a clock before.
  reg index_1 = 0;

  always @(posedge clk) begin
    pins_1 <= {b, a};
    pins_2 <= pins_1;
    pins_3 <= pins_2;
    sample_1 <= sample;
    error_1 <= error;
    error_2 <= error_1;
    out_of_reset <= rst ? 0 : {out_of_reset[0], 1'b1};
    error_3 <= error_2 && out_of_reset[1] && !rst;

    seen <= 1;
    rst_1 <= rst;
    valid_1 <= count_valid;
    count_1 <= count;
    plus_1 <= count + 1;
    minus_1 <= count - 1;
    index_position_1 <= cfg_index_position;
    referenced_1 <= referenced;
    illegal_1 <= illegal;
    clear_1 <= cfg_clear;
    pulse_1 <= |\dut.dropped [1:0];
    level_1 <= level;
    passed_1 <= passed;
    told_1 <= \dut.lost_cycle || \dut.lost_index || \dut.broken ;

    watched <= !rst && count_valid && (watched || start && agree);
    watched_1 <= watched && !restart;
    watched_2 <= watched_1 && !restart;
    ahead <= restart ? 0 : ahead_now;
    both <= both_now && !restart;
    lost <= lost_now && !restart;
    lost_1 <= lost && !restart;
    lost_2 <= lost_1 && !restart;
    told <= (told || illegal) && !restart;

    enable_1 <= cfg_home_enable && !rst;
    low <= cfg_home_enable && enable_1 && (low || \dut.valid [2] && !\dut.level [2] && level == 2'b11);
    low_1 <= low;
    index_1 <= \dut.valid [2] && \dut.level [2];
  end

  wire homed = referenced && !referenced_1;
  // A clock that neither starts nor ends in reset, with a count before it.
  wire follows = seen && !rst_1 && valid_1;

  always @* begin
    index_is_watched_once_it_is_known : assert (!seen || \dut.z_1 == index_1);
    if (follows && !homed) begin
      moves_by_at_most_one : assert (count == count_1 || count == plus_1 || count == minus_1);
      counts_every_edge : assert (count == (passed_1 == UP ? plus_1 : passed_1 == DOWN ? minus_1 : count_1));
      direction_is_that_of_the_edge : assert (passed_1 != UP && passed_1 != DOWN || direction == (passed_1 == UP));
    end
    if (follows) begin
      speed_meter_is_told_of_each_edge :
      assert (\dut.step_valid == (passed_1 == UP || passed_1 == DOWN) && \dut.step_illegal == (passed_1 == BOTH));
      illegal_edge_is_flagged : assert (passed_1 != BOTH || illegal);
      what_is_told_is_flagged : assert (!told_1 || illegal);
      error_is_flagged : assert (!error_3 || illegal);
      flagged_counts_end_the_reference : assert (!(illegal && (!illegal_1 || told_1)) || !referenced || homed);
      nothing_else_is_flagged : assert (illegal == (passed_1 == BOTH || told_1 || error_3 || illegal_1 && !clear_1));
      dropped_pulse_is_flagged : assert (!pulse_1 || glitch);
      homing_sets_the_index_position : assert (!homed || count == index_position_1);
      homing_has_seen_a_low_index : assert (!homed || low_1);
    end
    lost_counts_are_told : assert (!lost_2 || told || illegal);
    no_other_count_is_told_as_lost : assert (!\dut.lost_cycle || !watched_2 || lost_1);
    if (seen && rst_1) begin
      reset_clears : assert ({count_valid, count, direction, referenced, illegal, glitch, speed_valid, speed_zero} == 0);
      reset_forgets_the_speed : assert (speed_period == 32'h7fff_ffff);
    end
  end

endmodule
