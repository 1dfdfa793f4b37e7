// Claims of gc_biss about its line, its frames and its position, for every level of the line in every clock. BITS:
// position_bits_g; HALF, PERIODS, REST: half_clocks_g, start_periods_g, rest_clocks_g.
module biss #(
    parameter BITS = 2,
    parameter HALF = 2,
    parameter PERIODS = 2,
    parameter REST = 3
) (
    input clk,
    input rst,
    input in_valid,
    input slo,
    input clear
);

  // position, nE, nW and CRC
  localparam FRAME = BITS + 8;
  // Clocks to the error without a start bit; the period of the acknowledgement is one more.
  localparam GIVES_UP = 2 * HALF * PERIODS;
  localparam LONGEST = 2 * HALF * (PERIODS + FRAME + 2) + REST + 1;

  wire ma, out_valid, known, error, warning;
  wire [31:0] count;
  (* hierconn *) wire \dut.slo ;
  (* hierconn *) wire [2:0] \dut.state ;

  gc_biss dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .pin_ma(ma), .pin_slo(slo), .out_valid(out_valid), .out_count(count),
      .out_known(known), .cfg_clear(clear), .sts_error(error), .sts_warning(warning)
  );

  wire busy = \dut.state != 0;

  // The clock before; power-up is a reset.
  reg rst_1 = 1, clear_1 = 0, ma_1 = 1, slo_1 = 1, busy_1 = 0, asked_1 = 0, known_1 = 0, error_1 = 0;
  reg [31:0] count_1 = 0;
  // What was read as MA rose; clocks since it last changed, which stop at REST; clocks of a frame.
  reg [FRAME-1:0] taken = 0;
  reg [7:0] since = REST, clocks = 0;
  // There was an error in this frame: one that waits too long is told at once, and may be cleared before it ends.
  reg told = 0;

  wire rises = ma && !ma_1;
  wire [FRAME-1:0] all = rises ? {taken[FRAME-2:0], slo_1} : taken;

  always @(posedge clk) begin
    {rst_1, clear_1, ma_1, slo_1, busy_1} <= {rst, clear, ma, \dut.slo , busy};
    asked_1 <= in_valid && !busy;
    {known_1, error_1, count_1} <= {known, error, count};
    taken <= all;
    since <= ma != ma_1 ? 1 : since == REST ? since : since + 1;
    clocks <= busy ? clocks + 1 : 0;
    told <= busy && (told || error);
  end

  // x**6 + x + 1, by long division of the bits and six zeros.
  reg [FRAME-1:0] rest;
  integer k;
  always @* begin
    rest = {all[FRAME-1:6], 6'b0};
    for (k = FRAME - 1; k >= 6; k = k - 1) if (rest[k]) rest = rest ^ (7'b1000011 << (k - 6));
  end

  wire right = rest[5:0] == ~all[5:0] && all[7];

  always @* begin
    only_a_right_frame_is_taken : assert (!out_valid || right);
    position_is_that_of_the_frame : assert (!out_valid || count == {{(32 - BITS) {all[FRAME-1]}}, all[FRAME-1:8]});
    warning_is_that_of_the_frame : assert (!out_valid || warning == !all[6]);
    position_holds_between_frames : assert (out_valid || rst_1 || count == count_1);
    every_frame_ends_in_a_position_or_an_error : assert (rst_1 || !busy_1 || busy || out_valid || error || told);
    every_frame_ends_in_a_position_or_unknown : assert (rst_1 || !busy_1 || busy || out_valid || !known);
    low_line_is_told : assert (rst_1 || !asked_1 || slo_1 || error && !busy);
    error_lasts_until_it_is_cleared : assert (rst_1 || clear_1 || !error_1 || error);
    unknown_until_a_frame_is_right : assert (rst_1 || known_1 || !known || out_valid);
    unknown_with_a_new_error : assert (error_1 || !error || !known);
    line_rests_between_frames : assert (rst_1 || !(ma_1 && !ma) || since >= HALF);
    line_is_high_without_a_frame : assert (busy || ma);
    gives_up_after_the_periods : assert (rst_1 || !(busy_1 && busy && error) || error_1 || clocks == GIVES_UP
                                         || clocks == GIVES_UP + 2 * HALF);
    frame_ends_in_time : assert (clocks <= LONGEST);
  end

endmodule
