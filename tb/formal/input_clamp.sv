// Claims of gc_input_scaler, for every count: x is that of the count clamped to the trained range.
//
// LOW, HIGH: the trained range. x = (count >>> SHIFT) * SCALE >>> FRACTION, its product any value in the place of the
// right one; of each axis, 6 bits. LATENCY: clocks from count to x, PRODUCT_CLOCKS of them from product to x.
module input_clamp #(
    parameter [95:0] LOW = 0,
    parameter [95:0] HIGH = 0,
    parameter [53:0] SCALE = 0,
    parameter [17:0] SHIFT = 0,
    parameter [17:0] FRACTION = 0,
    parameter LATENCY = 3,
    parameter PRODUCT_CLOCKS = 1
) (
    input clk,
    input rst,
    input in_valid,
    input [95:0] in_count
);

  wire [53:0] x, x_low, x_high;
  wire [2:0] clamped;
  (* hierconn *) wire [53:0] \dut.codes ;
  (* hierconn *) wire [107:0] \dut.product ;

  gc_input_scaler dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_count(in_count), .out_x(x), .out_clamped(clamped),
      .scalars_count_low(LOW), .scalars_count_high(HIGH), .scalars_x_low(x_low), .scalars_x_high(x_high),
      .scalars_input_scale(SCALE)
  );

  // Bit k: counts came k clocks ago, and no reset since.
  reg [LATENCY:1] taken = 0;
  // The counts of the last clocks, newest lowest.
  reg [96*LATENCY-1:0] counts;
  reg [107:0] product_1;

  always @(posedge clk) begin
    taken <= rst ? 0 : {taken, in_valid};
    counts <= {counts, in_count};
    product_1 <= \dut.product ;
  end

  wire [107:0] products = PRODUCT_CLOCKS ? product_1 : \dut.product ;
  wire [2:0] codes_right, x_right, flags_right;

  genvar i;
  generate
    for (i = 0; i < 3; i = i + 1) begin : g_axis
      wire signed [31:0] low = LOW[32*i+:32], high = HIGH[32*i+:32];
      wire signed [31:0] now = in_count[32*i+:32], then = counts[96*(LATENCY-1)+32*i+:32];
      wire signed [17:0] scale = SCALE[18*i+:18];
      localparam [5:0] shift = SHIFT[6*i+:6], fraction = FRACTION[6*i+:6];
      wire signed [17:0] code = \dut.codes [18*i+:18];
      wire signed [35:0] product = products[36*i+:36];

      // What the limits become; a product in the range lies between theirs.
      wire signed [49:0] low_x = (low >>> shift) * scale >>> fraction;
      wire signed [49:0] high_x = (high >>> shift) * scale >>> fraction;
      wire fit = low_x >= -50'sd131072 && high_x <= 50'sd131071;
      wire signed [35:0] wanted = then < low ? low_x : then > high ? high_x : product >>> fraction;

      assign x_low[18*i+:18] = low_x[17:0];
      assign x_high[18*i+:18] = high_x[17:0];
      assign codes_right[i] = now < low || now > high || code == now >>> shift;
      assign x_right[i] = fit && x[18*i+:18] == wanted[17:0];
      assign flags_right[i] = clamped[i] == (then < low || then > high);
    end
  endgenerate

  always @* begin
    counts_in_range_are_multiplied_whole : assert (&codes_right);
    counts_outside_are_clamped : assert (!taken[LATENCY] || &x_right);
    clamped_counts_are_flagged : assert (!taken[LATENCY] || &flags_right);
  end

endmodule
