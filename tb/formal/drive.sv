// Claims of gc_drive about command, limits and flags, for every behaviour of the core, the host and the safety.
//
// Inductive: what a register of the pipeline holds is asserted for the clocks in which it is used, so that each clock
// follows from the one before. Sums are wider than they need to be. AXIS: which one, 0 the first; the other two are
// copies, and all three at once take the solver minutes.
module drive #(
    parameter AXIS = 0
) (
    input clk,
    input rst,
    input run,
    input in_valid,
    input [95:0] in_current,
    input [2:0] in_clipped,
    input [92:0] cfg_limit,
    input [92:0] cfg_slew,
    input [92:0] cfg_bound
);

  wire out_valid;
  wire [95:0] out_current;
  wire [2:0] out_limited, out_reached, out_deviates;
  (* hierconn *) wire [4:0] \dut.valid ;
  (* hierconn *) wire \dut.valid_7 ;
  (* hierconn *) wire [31:0] \dut.g_axis_n1_ceiling , \dut.g_axis_n2_ceiling , \dut.g_axis_n3_ceiling ;
  (* hierconn *) wire [31:0] \dut.g_axis_n1_rise , \dut.g_axis_n2_rise , \dut.g_axis_n3_rise ;
  (* hierconn *) wire [31:0] \dut.g_axis_n1_above , \dut.g_axis_n2_above , \dut.g_axis_n3_above ;

  gc_drive dut (
      .clk(clk), .rst(rst), .run(run), .in_valid(in_valid), .in_current(in_current), .in_clipped(in_clipped),
      .cfg_limit(cfg_limit), .cfg_slew(cfg_slew), .cfg_bound(cfg_bound), .out_valid(out_valid),
      .out_current(out_current), .out_limited(out_limited), .out_reached(out_reached), .out_deviates(out_deviates)
  );

  // Bit k: a result was taken k clocks ago, and no stop since. The limits of the clock before it.
  reg [8:1] taken_then = 0;
  reg stopped_1 = 1;
  reg [30:0] limit = 0, slew = 0, bound = 0;
  // The highest limit given since the last stop.
  reg [30:0] highest = 0;

  wire stopped = rst || !run;
  wire [30:0] given_limit = cfg_limit[31*AXIS+:31], given_slew = cfg_slew[31*AXIS+:31];
  wire [30:0] given_bound = cfg_bound[31*AXIS+:31];
  wire taken = in_valid && taken_then[5:1] == 0;

  always @(posedge clk) begin
    taken_then <= stopped ? 0 : {taken_then, taken};
    stopped_1 <= stopped;
    bound <= given_bound;
    highest <= (stopped ? limit : highest) > given_limit ? (stopped ? limit : highest) : given_limit;
    if (!taken && taken_then[4:1] == 0) {limit, slew} <= {given_limit, given_slew};
  end

  (* hierconn *) wire [31:0] \dut.g_axis_n1_asked_1 , \dut.g_axis_n2_asked_1 , \dut.g_axis_n3_asked_1 ;
  (* hierconn *) wire [31:0] \dut.g_axis_n1_target_2 , \dut.g_axis_n2_target_2 , \dut.g_axis_n3_target_2 ;
  (* hierconn *) wire [32:0] \dut.g_axis_n1_gap_3 , \dut.g_axis_n2_gap_3 , \dut.g_axis_n3_gap_3 ;
  (* hierconn *) wire [31:0] \dut.g_axis_n1_step_5 , \dut.g_axis_n2_step_5 , \dut.g_axis_n3_step_5 ;
  (* hierconn *) wire [32:0] \dut.g_axis_n1_miss_7 , \dut.g_axis_n2_miss_7 , \dut.g_axis_n3_miss_7 ;
  (* hierconn *) wire \dut.g_axis_n1_above_1 , \dut.g_axis_n2_above_1 , \dut.g_axis_n3_above_1 ;
  (* hierconn *) wire \dut.g_axis_n1_below_1 , \dut.g_axis_n2_below_1 , \dut.g_axis_n3_below_1 ;
  (* hierconn *) wire \dut.g_axis_n1_above_4 , \dut.g_axis_n2_above_4 , \dut.g_axis_n3_above_4 ;
  (* hierconn *) wire \dut.g_axis_n1_below_4 , \dut.g_axis_n2_below_4 , \dut.g_axis_n3_below_4 ;
  (* hierconn *) wire \dut.g_axis_n1_clipped_1 , \dut.g_axis_n2_clipped_1 , \dut.g_axis_n3_clipped_1 ;

  wire [95:0] all_asked = {\dut.g_axis_n3_asked_1 , \dut.g_axis_n2_asked_1 , \dut.g_axis_n1_asked_1 };
  wire [95:0] all_target = {\dut.g_axis_n3_target_2 , \dut.g_axis_n2_target_2 , \dut.g_axis_n1_target_2 };
  wire [98:0] all_gap = {\dut.g_axis_n3_gap_3 , \dut.g_axis_n2_gap_3 , \dut.g_axis_n1_gap_3 };
  wire [95:0] all_step = {\dut.g_axis_n3_step_5 , \dut.g_axis_n2_step_5 , \dut.g_axis_n1_step_5 };
  wire [98:0] all_miss = {\dut.g_axis_n3_miss_7 , \dut.g_axis_n2_miss_7 , \dut.g_axis_n1_miss_7 };
  wire [95:0] all_ceiling = {\dut.g_axis_n3_ceiling , \dut.g_axis_n2_ceiling , \dut.g_axis_n1_ceiling };
  wire [95:0] all_rise = {\dut.g_axis_n3_rise , \dut.g_axis_n2_rise , \dut.g_axis_n1_rise };
  wire [95:0] all_above = {\dut.g_axis_n3_above , \dut.g_axis_n2_above , \dut.g_axis_n1_above };
  wire [2:0] above_1 = {\dut.g_axis_n3_above_1 , \dut.g_axis_n2_above_1 , \dut.g_axis_n1_above_1 };
  wire [2:0] below_1 = {\dut.g_axis_n3_below_1 , \dut.g_axis_n2_below_1 , \dut.g_axis_n1_below_1 };
  wire [2:0] above_4 = {\dut.g_axis_n3_above_4 , \dut.g_axis_n2_above_4 , \dut.g_axis_n1_above_4 };
  wire [2:0] below_4 = {\dut.g_axis_n3_below_4 , \dut.g_axis_n2_below_4 , \dut.g_axis_n1_below_4 };
  wire [2:0] clipped_1 = {\dut.g_axis_n3_clipped_1 , \dut.g_axis_n2_clipped_1 , \dut.g_axis_n1_clipped_1 };

  wire signed [31:0] dut_ceiling = all_ceiling[32*AXIS+:32], dut_rise = all_rise[32*AXIS+:32];
  wire signed [31:0] dut_above = all_above[32*AXIS+:32];
  wire signed [31:0] command = out_current[32*AXIS+:32];
  wire signed [31:0] target_2 = all_target[32*AXIS+:32], step_5 = all_step[32*AXIS+:32];
  wire signed [32:0] gap_3 = all_gap[33*AXIS+:33], miss_7 = all_miss[33*AXIS+:33];
  // The last result taken; the clock before: command, what it shall become, and what it misses.
  reg signed [31:0] asked = 0, command_1 = 0;
  reg clipped = 0, limited_1 = 0;
  reg [2:0] flags_1 = 0;
  reg signed [33:0] target_1 = 0, step_1 = 0, miss_1 = 0, miss_2 = 0, margin_1 = 0;

  wire [2:0] flags = {out_limited[AXIS], out_reached[AXIS], out_deviates[AXIS]};
  wire signed [33:0] most = limit, rise = slew, margin = bound, ceiling = highest;
  wire signed [33:0] target = asked > most ? most : asked < -most ? -most : asked;
  wire signed [33:0] gap = target - command;
  wire signed [33:0] step = gap > rise ? rise : gap < -rise ? -rise : gap;

  always @(posedge clk) begin
    if (taken) {asked, clipped} <= {in_current[32*AXIS+:32], in_clipped[AXIS]};
    command_1 <= command;
    limited_1 <= asked > most || asked < -most;
    flags_1 <= flags;
    target_1 <= target;
    step_1 <= step;
    miss_1 <= asked - command;
    miss_2 <= miss_1;
    margin_1 <= margin;
  end

  wire [5:1] t = taken_then[5:1];
  wire within = command_1 <= target_1 ? command >= command_1 && command <= target_1
                                      : command <= command_1 && command >= target_1;
  wire follow =
      asked == $signed(all_asked[32*AXIS+:32]) && clipped == clipped_1[AXIS] && miss_7 == miss_1
      && (!(|t) || above_1[AXIS] == (asked > most) && below_1[AXIS] == (asked < -most))
      && (!(|t[5:2]) || target_2 == target)
      && (!(|t[5:3]) || gap_3 == gap)
      && (!(|t[5:4]) || above_4[AXIS] == (gap > rise) && below_4[AXIS] == (gap < -rise))
      && (!t[5] || step_5 == step);
  wire inside = !out_valid || within;
  wire small = !out_valid || command == command_1 + step_1;
  wire within_limits = command <= ceiling && command >= -ceiling;
  wire limits = !out_valid || out_limited[AXIS] == limited_1;
  wire reaches = !out_valid || out_reached[AXIS] == (command == asked && !limited_1 && !clipped);
  wire deviates = !taken_then[8] || out_deviates[AXIS] == (miss_2 > margin_1 || miss_2 < -margin_1);
  wire holds = stopped_1
      || (out_valid || command == command_1 && flags[2:1] == flags_1[2:1])
      && (taken_then[8] || flags[0] == flags_1[0]);
  wire stops = !stopped_1 || command == 0 && flags == 0;
  // Of any six clocks one takes a result at most.
  wire [5:0] t_1 = taken_then[6:1], t_2 = taken_then[7:2], t_3 = taken_then[8:3];

  always @* begin
    results_are_six_clocks_apart : assert ((t_1 & t_1 - 1) == 0 && (t_2 & t_2 - 1) == 0 && (t_3 & t_3 - 1) == 0);
    results_pass_through :
      assert (\dut.valid == {taken_then[1], taken_then[2], taken_then[3], taken_then[4], taken_then[5]}
              && out_valid == taken_then[6] && \dut.valid_7 == taken_then[7]);
    limits_are_those_of_the_result :
      assert (dut_ceiling == limit && dut_rise == slew && dut_above == bound);
    limit_is_one_of_those_given : assert (limit <= highest);
    stages_hold_what_they_should : assert (follow);
    command_stays_between_its_last_value_and_the_target : assert (inside);
    command_moves_by_the_slew_at_most : assert (small);
    command_never_leaves_the_limits_given : assert (within_limits);
    clipped_currents_are_flagged : assert (limits);
    reached_is_the_whole_current : assert (reaches);
    deviation_is_a_distance_beyond_the_bound : assert (deviates);
    command_and_flags_hold_between_results : assert (holds);
    stop_is_zero_one_clock_later : assert (stops);
  end

endmodule
