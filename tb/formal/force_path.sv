// Claims of gc_force_path about its outputs, for every behaviour of pins and configuration.
//
// LATENCY: clocks from an accepted in_valid to out_valid.
module force_path #(
    parameter LATENCY = 1
) (
    input clk,
    input rst,
    input [2:0] pin_a,
    input [2:0] pin_b,
    input [2:0] pin_z,
    input [2:0] cfg_home_enable,
    input [95:0] cfg_index_position,
    input cfg_clear,
    input in_valid
);

  wire in_ready, out_valid;
  wire [71:0] out_force;
  wire [95:0] out_current, sts_count, sts_speed_period;
  wire [2:0] out_clamped, out_saturated, direction, speed_valid, speed_zero, referenced, illegal, glitch;

  gc_force_path dut (
      .clk(clk), .rst(rst), .pin_a(pin_a), .pin_b(pin_b), .pin_z(pin_z), .cfg_home_enable(cfg_home_enable),
      .cfg_index_position(cfg_index_position), .cfg_clear(cfg_clear), .in_valid(in_valid), .in_ready(in_ready),
      .out_valid(out_valid), .out_force(out_force), .out_current(out_current), .out_clamped(out_clamped),
      .out_saturated(out_saturated), .sts_count(sts_count), .sts_direction(direction),
      .sts_speed_period(sts_speed_period), .sts_speed_valid(speed_valid), .sts_speed_zero(speed_zero),
      .sts_referenced(referenced), .sts_illegal(illegal), .sts_glitch(glitch)
  );

  wire [173:0] command = {out_force, out_current, out_clamped, out_saturated};

  reg seen = 0, rst_1;
  reg [173:0] command_1;
  // Bit k: counts were accepted k clocks ago, and no reset since.
  reg [LATENCY:1] taken = 0;

  always @(posedge clk) begin
    seen <= 1;
    rst_1 <= rst;
    command_1 <= command;
    taken <= rst ? 0 : {taken, in_valid && in_ready};
  end

  always @* begin
    none_lost : assert (!taken[LATENCY] || out_valid);
    none_invented : assert (!out_valid || taken[LATENCY]);
    if (seen && !rst_1) command_holds_between_results : assert (out_valid || command == command_1);
    if (seen && rst_1) begin
      reset_takes_the_command_to_zero : assert (command == 0 && !out_valid);
      reset_waits_for_the_encoders : assert (!in_ready);
      reset_clears_the_status : assert ({sts_count, direction, speed_valid, speed_zero, referenced, illegal, glitch} == 0);
    end
  end

endmodule
