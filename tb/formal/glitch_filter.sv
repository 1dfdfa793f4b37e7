// Claims of gc_glitch_filter, for every sequence of samples. SAMPLES: samples_g.
module glitch_filter #(
    parameter SAMPLES = 4
) (
    input clk,
    input rst,
    input in_valid,
    input in_level
);

  wire out_valid, out_level, out_dropped;

  gc_glitch_filter dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_level(in_level), .out_valid(out_valid), .out_level(out_level),
      .out_dropped(out_dropped)
  );

  // The last samples, newest lowest, and how many of them came since in_valid rose or a reset.
  reg [SAMPLES-1:0] last = 0;
  reg [$clog2(SAMPLES):0] n_samples = 0;
  // The clock before.
  reg running_1 = 0, valid_1 = 0, level_1 = 0, differs_1 = 0, ended_1 = 0;

  wire running = in_valid && !rst;

  always @(posedge clk) begin
    running_1 <= running;
    last <= {last, in_level};
    n_samples <= !running ? 0 : n_samples == SAMPLES ? n_samples : n_samples + 1;
    valid_1 <= out_valid;
    level_1 <= out_level;
    differs_1 <= running && out_valid && in_level != out_level;
    ended_1 <= running && out_valid && in_level == out_level && differs_1 && out_level == level_1;
  end

  wire steady = n_samples == SAMPLES && (last == 0 || &last);

  always @* begin
    short_pulse_never_passes : assert (!(valid_1 && out_valid && out_level != level_1) || steady && out_level == last[0]);
    long_level_always_passes : assert (!steady || out_valid && out_level == last[0]);
    dropped_pulse_is_reported : assert (out_dropped == ended_1);
    reset_forgets_the_level : assert (running_1 || !out_valid);
  end

endmodule
