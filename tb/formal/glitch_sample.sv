// Claim of gc_glitch_filter about the sample beside its level, for every sequence of samples. SAMPLES: samples_g.
module glitch_sample #(
    parameter SAMPLES = 4
) (
    input clk,
    input rst,
    input in_valid,
    input in_level
);

  wire out_sample;

  gc_glitch_filter dut (.clk(clk), .rst(rst), .in_valid(in_valid), .in_level(in_level), .out_sample(out_sample));

  reg level_1 = 0;

  always @(posedge clk) level_1 <= in_level;

  always @* sample_is_the_newest : assert (out_sample == (SAMPLES == 0 ? in_level : level_1));

endmodule
