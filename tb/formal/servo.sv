// Claims of gc_servo with one axis about correction, sum and stop, for every product: whatever gains and errors are.
module servo (
    input clk,
    input rst,
    input run,
    input in_valid,
    input [31:0] in_count,
    input [31:0] in_setpoint,
    input [31:0] cfg_proportional,
    input [31:0] cfg_integral,
    input [31:0] cfg_derivative,
    input [3:0] cfg_filter,
    input cfg_speed_feed,
    input [30:0] cfg_limit,
    input [31:0] cfg_astray,
    input feed_valid,
    input [31:0] feed_current
);

  wire out_valid, out_astray;
  wire signed [31:0] out_current, sts_correction;

  gc_servo dut (
      .clk(clk), .rst(rst), .run(run), .in_valid(in_valid), .in_count(in_count), .in_setpoint(in_setpoint),
      .cfg_proportional(cfg_proportional), .cfg_integral(cfg_integral), .cfg_derivative(cfg_derivative),
      .cfg_filter(cfg_filter), .cfg_speed_feed(cfg_speed_feed), .cfg_limit(cfg_limit), .cfg_astray(cfg_astray),
      .feed_valid(feed_valid), .feed_current(feed_current), .out_valid(out_valid), .out_current(out_current), .out_astray(out_astray),
      .sts_correction(sts_correction)
  );

  // The clock before. Sums are wider than they need to be.
  reg stopped_1 = 1, rst_1 = 1, valid_1 = 0;
  reg signed [33:0] correction_1 = 0, limit_1 = 0, sum_1 = 0;
  reg signed [31:0] current_1 = 0;

  always @(posedge clk) begin
    stopped_1 <= rst || !run;
    {rst_1, valid_1} <= {rst, feed_valid};
    correction_1 <= sts_correction;
    limit_1 <= cfg_limit;
    sum_1 <= $signed(feed_current) + sts_correction;
    current_1 <= out_current;
  end

  wire signed [33:0] correction = sts_correction, current = out_current;
  wire signed [33:0] most = 34'sh07fffffff, least = -34'sh080000000;
  wire signed [33:0] whole = sum_1 > most ? most : sum_1 < least ? least : sum_1;

  always @* begin
    stop_is_zero_one_clock_later : assert (!stopped_1 || correction == 0 && !out_astray);
    correction_never_exceeds_its_limit :
      assert (correction == correction_1 || correction <= limit_1 && correction >= -limit_1);
    feed_forward_is_answered : assert (out_valid == (valid_1 && !rst_1));
    sum_is_exact_or_saturated : assert (!out_valid || current == whole);
    command_holds_between : assert (valid_1 || rst_1 || out_current == current_1);
    reset_clears : assert (!rst_1 || !out_valid && out_current == 0);
  end

endmodule
