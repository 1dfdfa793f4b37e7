// Claims of gc_safety about brakes, command and faults, for every behaviour of pins, host, core and limits. Parameters:
// codes of the states, bits of the causes.
module safety #(
    parameter [2:0] BRAKED = 0,
    parameter [2:0] HOLDING = 0,
    parameter [2:0] RUN = 0,
    parameter [2:0] FAULT = 0,
    parameter SPEED = 0,
    parameter COMMAND = 0,
    parameter HOLD = 0,
    parameter BRAKE = 0,
    parameter UPSET = 0
) (
    input clk,
    input rst,
    input estop_n,
    input enable,
    input [16:0] clear,
    input kick,
    input [95:0] in_count,
    input [95:0] in_period,
    input [2:0] in_referenced,
    input [2:0] in_illegal,
    input in_result,
    input [2:0] in_clamped,
    input [2:0] in_saturated,
    input [2:0] in_reached,
    input [2:0] in_deviates,
    input in_crc_bad,
    input in_rom_bad,
    input in_clock_bad,
    input in_core_bad,
    input in_upset,
    input [2:0] in_astray,
    input [95:0] cfg_count_low,
    input [95:0] cfg_count_high,
    input [92:0] cfg_period_min,
    input [31:0] cfg_saturation_clocks,
    input [31:0] cfg_watchdog_clocks,
    input [31:0] cfg_result_clocks,
    input [31:0] cfg_command_clocks,
    input [31:0] cfg_hold_clocks,
    input [31:0] cfg_brake_clocks
);

  wire run;
  wire [2:0] brake_release, brake_engage, state;
  wire [16:0] present, fault, first_cause;
  wire [95:0] first_count;
  wire [7:0] events;

  gc_safety dut (
      .clk(clk), .rst(rst), .estop_n(estop_n), .enable(enable), .clear(clear), .kick(kick), .in_count(in_count),
      .in_period(in_period), .in_referenced(in_referenced), .in_illegal(in_illegal), .in_result(in_result),
      .in_clamped(in_clamped), .in_saturated(in_saturated), .in_reached(in_reached), .in_deviates(in_deviates),
      .in_crc_bad(in_crc_bad), .in_rom_bad(in_rom_bad), .in_clock_bad(in_clock_bad), .in_core_bad(in_core_bad),
      .in_upset(in_upset), .in_astray(in_astray), .brake_fed(3'b0), .cfg_count_low(cfg_count_low), .cfg_count_high(cfg_count_high),
      .cfg_period_min(cfg_period_min), .cfg_saturation_clocks(cfg_saturation_clocks),
      .cfg_watchdog_clocks(cfg_watchdog_clocks), .cfg_result_clocks(cfg_result_clocks),
      .cfg_command_clocks(cfg_command_clocks), .cfg_hold_clocks(cfg_hold_clocks),
      .cfg_brake_clocks(cfg_brake_clocks), .cfg_test_clocks(32'b0), .run(run), .brake_release(brake_release),
      .brake_engage(brake_engage), .sts_state(state),
      .sts_present(present), .sts_fault(fault), .sts_first_cause(first_cause), .sts_first_count(first_count),
      .sts_events(events)
  );

  // The last clocks; enable counts as high before power-up.
  reg rst_1 = 1, upset_1 = 0, run_1 = 0, enable_1 = 1, enable_2 = 1;
  reg [1:3] estop_n_then = 0;
  reg [1:2] illegal_then = 0, unreferenced_then = 0, astray_then = 0;
  reg [2:0] state_1 = BRAKED, brake_release_1 = 0;
  reg [16:0] clear_1 = 0, present_1 = 0, fault_1 = 0, first_cause_1 = 0;
  reg [95:0] first_count_1;
  reg [7:0] events_1 = 0;

  // Speed limit: 0 allows none, and what is less than can be measured means the lowest of that.
  reg [2:0] speeding_1 = 0;
  genvar i;
  generate
    for (i = 0; i < 3; i = i + 1) begin : g_speed
      reg signed [31:0] limit_1 = 32'h7fff_ffff, limit_2 = 32'h7fff_ffff, floor_2 = -32'h7fff_ffff;
      wire [30:0] least = cfg_period_min[31*i+:31];
      wire signed [31:0] limit = least == 0 ? 32'h7fff_ffff : least <= 8 ? 9 : least;
      wire signed [31:0] period = in_period[32*i+:32];

      always @(posedge clk) begin
        limit_1 <= limit;
        limit_2 <= limit_1;
        floor_2 <= -limit_1;
        speeding_1[i] <= !rst && period > floor_2 && period < limit_2;
      end
    end
  endgenerate

  // Clocks without a break, up to a limit, in which the motors carried the load (or the brakes closed), a command deviated,
  // HOLDING lasted; and in the clock before, whether they were more than the limit.
  wire carries = state == HOLDING && enable == enable_1 && (!enable || (&in_reached));
  wire deviates = brake_release != 0 && in_deviates != 0;
  wire holds = state == HOLDING && enable;
  reg [31:0] carried = 0, deviated = 0, held = 0;
  reg carries_1 = 0, carried_long_enough = 0, carried_long_enough_1 = 0, deviated_too_long = 0, held_too_long = 0;
  reg deviated_too_long_1 = 0, held_too_long_1 = 0;

  always @(posedge clk) begin
    carries_1 <= carries;
    carried <= rst || !carries ? 0 : carried + (carried < cfg_brake_clocks);
    deviated <= rst || !deviates ? 0 : deviated + (deviated < cfg_command_clocks);
    held <= rst || !holds ? 0 : held + (held < cfg_hold_clocks);
    carried_long_enough <= !rst && carries && carried >= cfg_brake_clocks;
    deviated_too_long <= !rst && deviates && deviated >= cfg_command_clocks;
    held_too_long <= !rst && holds && held >= cfg_hold_clocks;
    {carried_long_enough_1, deviated_too_long_1, held_too_long_1} <= {carried_long_enough, deviated_too_long, held_too_long};
    rst_1 <= rst;
    upset_1 <= in_upset;
    clear_1 <= clear;
    run_1 <= run;
    enable_1 <= enable;
    enable_2 <= enable_1;
    estop_n_then <= {estop_n, estop_n_then[1:2]};
    illegal_then <= {|in_illegal, illegal_then[1]};
    unreferenced_then <= {!(&in_referenced), unreferenced_then[1]};
    astray_then <= {|in_astray, astray_then[1]};
    state_1 <= state;
    brake_release_1 <= brake_release;
    present_1 <= present;
    fault_1 <= fault;
    first_cause_1 <= first_cause;
    first_count_1 <= first_count;
    events_1 <= events;
  end

  always @* begin
    state_is_legal : assert (state == BRAKED || state == HOLDING || state == RUN || state == FAULT);
    brakes_are_engaged_but_in_run : assert (brake_release == (state == RUN ? 3'b111 : 3'b000));
    both_paths_agree : assert (brake_engage == ~brake_release && !present[BRAKE]);
    nothing_is_upset_of_itself : assert (!present[UPSET] || upset_1);
    command_is_zero_braked_and_in_fault : assert (run == (state == HOLDING || state == RUN));
    brakes_open_after_the_motors_hold : assert (!brake_release || brake_release_1 || state_1 == HOLDING && enable_1);
    brakes_open_after_the_whole_command_was_reached :
      assert (!brake_release || brake_release_1 || enable_1 && carries_1 && carried_long_enough_1);
    lasting_deviation_engages_the_brakes : assert (!deviated_too_long_1 || !brake_release && !run);
    holding_ends_in_time : assert (!held_too_long_1 || brake_release_1 || !brake_release && !run);
    emergency_stop_engages_the_brakes : assert (estop_n_then[3] || !brake_release && !run);
    lost_counts_engage_the_brakes : assert (!illegal_then[2] || !brake_release && !run);
    lost_reference_engages_the_brakes : assert (!unreferenced_then[2] || !brake_release && !run);
    following_error_engages_the_brakes : assert (!astray_then[2] || !brake_release && !run);
    causes_engage_the_brakes : assert (!present_1 || !brake_release && !run);
    speed_is_held_against_every_limit : assert (present[SPEED] == |speeding_1);
    motion_starts_by_an_edge_while_healthy :
      assert (!run || run_1 || enable_1 && !enable_2 && !present_1 && state_1 == BRAKED);
    fault_lasts_until_all_are_cleared_and_no_cause_is_present :
      assert (state_1 != FAULT || state == FAULT || rst_1
              || (fault_1 & clear_1) != 0 && (fault_1 & ~clear_1) == 0 && !present_1 && state == BRAKED);
    fault_is_the_state_of_latched_causes : assert (fault != 0 == (state == FAULT));
    causes_are_kept_until_each_is_cleared : assert (rst_1 || (fault_1 & ~clear_1 & ~fault) == 0);
    only_cleared_causes_are_forgotten : assert (rst_1 || state_1 != FAULT || (present_1 & ~fault) == 0);
    no_cause_comes_of_itself : assert ((fault & ~fault_1 & ~present_1) == 0);
    first_cause_is_of_the_clock_that_led_to_fault :
      assert (state != FAULT || state_1 == FAULT || first_cause == fault);
    first_cause_is_there_with_a_fault : assert ((first_cause != 0) == (fault != 0));
    every_fault_that_comes_is_an_event :
      assert (events == (rst_1 ? 8'd0 : events_1 + ((fault & ~fault_1) != 0)));
    // Cells that no test of causes in states can reach; tb/test_rtl_safety_cells.py reaches all others.
    command_is_absent_in_braked : assert (!present[COMMAND] || state != BRAKED);
    hold_is_absent_in_braked : assert (!present[HOLD] || state != BRAKED);
    hold_is_absent_in_run : assert (!present[HOLD] || state != RUN);
    first_is_kept :
      assert (rst_1 || state != FAULT || state_1 != FAULT || first_cause == first_cause_1 && first_count == first_count_1);
  end

endmodule
