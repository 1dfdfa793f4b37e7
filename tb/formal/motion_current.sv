// Claims of gc_motion about the current that it asks for and about a stop, for every product: whatever gains, targets and
// errors are. Words of its state and settings have the first axis highest, those of counts and currents lowest.
module motion_current #(
    parameter AXES = 1
) (
    input clk,
    input rst,
    input run,
    input released,
    input [31:0] move_ticks,
    input [3:0] filter,
    input speed_feed,
    input [AXES*32-1:0] target,
    input [AXES*32-1:0] speed_max,
    input [AXES*32-1:0] acceleration_max,
    input [AXES*32-1:0] proportional,
    input [AXES*32-1:0] integral,
    input [AXES*32-1:0] derivative,
    input [AXES*31-1:0] servo_limit,
    input [AXES*32-1:0] following_max,
    input move,
    input begins,
    input [AXES*32-1:0] count,
    input in_valid,
    input [AXES*32-1:0] in_current
);

  wire out_valid, ready;
  wire [AXES*32-1:0] out_current, setpoint, correction;
  wire [AXES-1:0] astray, following;

  gc_motion dut (
      .clk(clk), .rst(rst), .run(run), .released(released), .in_settings_move_ticks(move_ticks),
      .in_settings_filter(filter), .in_settings_speed_feed(speed_feed), .in_settings_target(target),
      .in_settings_speed_max(speed_max), .in_settings_acceleration_max(acceleration_max),
      .in_settings_proportional(proportional), .in_settings_integral(integral), .in_settings_derivative(derivative),
      .in_settings_servo_limit(servo_limit), .in_settings_following_max(following_max), .in_move(move),
      .in_begins(begins), .in_count(count), .in_valid(in_valid), .in_current(in_current), .out_valid(out_valid),
      .out_current(out_current), .out_astray(astray), .out_state_ready(ready), .out_state_following(following),
      .out_state_setpoint(setpoint), .out_state_correction(correction)
  );

  // The clock before.
  reg stopped_1 = 1, rst_1 = 1, valid_1 = 0;
  reg [AXES*32-1:0] count_1 = 0, asked_1 = 0, current_1 = 0, correction_1 = 0;
  reg [AXES*31-1:0] limit_1 = 0;

  always @(posedge clk) begin
    stopped_1 <= rst || !run;
    {rst_1, valid_1} <= {rst, in_valid};
    {count_1, asked_1, current_1} <= {count, in_current, out_current};
    {correction_1, limit_1} <= {correction, servo_limit};
  end

  // Of each axis: its setpoint is the count before; its correction is zero, or not beyond its limit, or as it was; its
  // current is the sum of the clock before. Sums are wider than they need to be.
  localparam signed [33:0] MOST = 34'sh07fffffff, LEAST = -34'sh080000000;
  wire [AXES-1:0] follows, is_zero, is_limited, is_sum;
  genvar i;
  generate
    for (i = 0; i < AXES; i = i + 1) begin : axis
      localparam TOP = AXES - 1 - i;
      wire signed [33:0] added = $signed(correction[32*TOP+:32]), before = $signed(correction_1[32*TOP+:32]);
      wire signed [33:0] limit = $signed({3'b0, limit_1[31*TOP+:31]}), asked = $signed(asked_1[32*i+:32]);
      wire signed [33:0] sum = asked + before, is = $signed(out_current[32*i+:32]);
      assign follows[i] = setpoint[32*TOP+:32] == count_1[32*i+:32];
      assign is_zero[i] = added == 0;
      assign is_limited[i] = added == before || added <= limit && added >= -limit;
      assign is_sum[i] = is == (sum > MOST ? MOST : sum < LEAST ? LEAST : sum);
    end
  endgenerate

  always @* begin
    each_result_has_its_current_a_clock_later : assert (out_valid == (valid_1 && !rst_1));
    current_is_the_sum_or_saturated : assert (!out_valid || &is_sum);
    current_holds_between_results : assert (valid_1 || rst_1 || out_current == current_1);
    no_current_after_a_reset : assert (!rst_1 || out_current == 0);
    limits_are_those_of_their_axes : assert (&is_limited);
    stop_ends_corrections_and_errors : assert (!stopped_1 || &is_zero && astray == 0);
    stop_lets_setpoints_follow : assert (!stopped_1 || &follows);
    no_move_is_offered_but_in_run : assert (!ready || run && released);
    astray_is_told : assert (following == astray);
  end

endmodule
