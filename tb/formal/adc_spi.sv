// Claims of gc_adc_spi about its pins and its codes, for every level of MISO in every clock, with two channels and frames
// of a number of one bit and a code of 8. HALF, GAP: half_clocks_g, gap_clocks_g.
module adc_spi #(
    parameter HALF = 3,
    parameter GAP = 2
) (
    input clk,
    input rst,
    input in_valid,
    input miso
);

  localparam FRAME = 9;

  wire cs_n, sclk, mosi;
  wire [1:0] valid;
  wire [63:0] current;
  wire [15:0] errors;

  gc_adc_spi dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .pin_cs_n(cs_n), .pin_sclk(sclk), .pin_mosi(mosi), .pin_miso(miso),
      .cfg_zero(32'd0), .cfg_scale(48'd0), .sense_valid(valid), .sense_current(current), .sts_errors(errors)
  );

  // The clock before; power-up is a reset.
  reg rst_1 = 1, cs_n_1 = 1, sclk_1 = 1, mosi_1 = 0;
  reg [63:0] current_1 = 0;
  reg [15:0] errors_1 = 0;
  // Falling edges of SCLK in this frame, clocks since SCLK or CS changed, and since CS rose; both stop at 15.
  reg [3:0] edges = 0, since = 15, apart = 15;

  wire falls = sclk_1 && !sclk, changes = sclk != sclk_1 || cs_n != cs_n_1;

  always @(posedge clk) begin
    {rst_1, cs_n_1, sclk_1, mosi_1, current_1, errors_1} <= {rst, cs_n, sclk, mosi, current, errors};
    edges <= cs_n ? 0 : edges + falls;
    since <= changes ? 1 : since == 15 ? since : since + 1;
    apart <= !cs_n ? 0 : apart == 15 ? apart : apart + 1;
  end

  always @* begin
    clock_rests_high_between_frames : assert (!cs_n || sclk);
    half_a_period_is_whole : assert (rst_1 || !changes || since >= HALF || cs_n_1 && !cs_n);
    frames_are_whole : assert (rst_1 || !(cs_n && !cs_n_1) || edges == FRAME);
    frames_are_apart : assert (rst_1 || !(cs_n_1 && !cs_n) || apart >= GAP + 1);
    data_change_as_the_clock_falls : assert (rst_1 || mosi == mosi_1 || falls);
    one_code_at_a_time : assert (!(valid[0] && valid[1]));
    currents_hold_between_codes : assert (rst_1 || current[31:0] == current_1[31:0] || valid[0]);
    errors_are_counted_one_by_one : assert (rst_1 || errors == errors_1 || errors == errors_1 + 1);
  end

endmodule
