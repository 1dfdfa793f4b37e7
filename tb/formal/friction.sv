// Claims of gc_friction with both tables, of whatever values: both are cut, so any value may come out of either.
//
// Both parts of the product are free, too, between their bounds: the magnitude of a force, 2^23 at most, as 17 bits and
// what is above them, times 18 bits.
module friction (
    input clk,
    input rst,
    input in_valid,
    input [23:0] in_force,
    input [31:0] in_period
);

  wire out_valid;
  wire signed [24:0] out_friction;
  (* hierconn *) wire signed [17:0] \dut.sliding_8 , \dut.g_load_mu_8 ;
  (* hierconn *) wire signed [35:0] \dut.g_load_i_multiply.g_wide_g_a_n1_g_b_n1_g_part_i_part.product ;
  (* hierconn *) wire signed [17:0] \dut.g_load_i_multiply.g_wide_g_a_n1_g_b_n1_g_part_i_part.a_1 ;
  (* hierconn *) wire signed [17:0] \dut.g_load_i_multiply.g_wide_g_a_n1_g_b_n1_g_part_i_part.b_1 ;
  (* hierconn *) wire signed [35:0] \dut.g_load_i_multiply.g_wide_g_a_n2_g_b_n1_g_part_i_part.product ;
  (* hierconn *) wire signed [17:0] \dut.g_load_i_multiply.g_wide_g_a_n2_g_b_n1_g_part_i_part.a_1 ;
  (* hierconn *) wire signed [17:0] \dut.g_load_i_multiply.g_wide_g_a_n2_g_b_n1_g_part_i_part.b_1 ;
  (* hierconn *) wire \dut.valid_3 ;

  gc_friction dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_force(in_force), .in_period(in_period), .out_valid(out_valid),
      .out_friction(out_friction)
  );

  // Clocks ago, of the inputs; of the table's value for the sum of the last stage; of the products.
  reg [12:1] valid_then = 0;
  reg [24*9-1:0] force_then;
  reg [3:0] n_clocks = 0;
  wire signed [35:0] low = \dut.g_load_i_multiply.g_wide_g_a_n1_g_b_n1_g_part_i_part.product ;
  wire signed [35:0] high = \dut.g_load_i_multiply.g_wide_g_a_n2_g_b_n1_g_part_i_part.product ;
  wire signed [17:0] low_a = \dut.g_load_i_multiply.g_wide_g_a_n1_g_b_n1_g_part_i_part.a_1 ;
  wire signed [17:0] low_b = \dut.g_load_i_multiply.g_wide_g_a_n1_g_b_n1_g_part_i_part.b_1 ;
  wire signed [17:0] high_a = \dut.g_load_i_multiply.g_wide_g_a_n2_g_b_n1_g_part_i_part.a_1 ;
  wire signed [17:0] high_b = \dut.g_load_i_multiply.g_wide_g_a_n2_g_b_n1_g_part_i_part.b_1 ;
  wire signed [42:0] product = low + (43'(high) << 17);
  reg signed [17:0] mu_1, sliding_1, sliding_2, sliding_3, sliding_4;
  reg signed [42:0] product_1, product_2, product_3;

  always @(posedge clk) begin
    valid_then <= rst ? 0 : {valid_then, in_valid};
    force_then <= {force_then, in_force};
    n_clocks <= n_clocks == 12 ? 12 : n_clocks + 1;
    mu_1 <= \dut.g_load_mu_8 ;
    {sliding_4, sliding_3, sliding_2, sliding_1} <= {sliding_3, sliding_2, sliding_1, \dut.sliding_8 };
    {product_3, product_2, product_1} <= {product_2, product_1, product};
  end

  wire signed [23:0] asked = force_then[24*8+:24];
  wire signed [24:0] magnitude = asked < 0 ? -asked : asked;
  // Both friction forces and half an LSB, in 2^-17 mN.
  wire signed [44:0] sliding = {{10{sliding_4[17]}}, sliding_4, 17'b0};
  wire signed [44:0] sum = sliding + product_3 + 45'sd65536;
  wire signed [44:0] rounded = sum >>> 17;

  always @* begin
    assume (low >= -36'sd17179869184 && low <= 36'sd17179869184);
    assume (high >= -36'sd8388608 && high <= 36'sd8388608);
    comes_after_twelve_clocks : assert (out_valid == valid_then[12]);
    place_comes_after_three_clocks : assert (\dut.valid_3 == valid_then[3]);
    load_is_multiplied_by_its_magnitude :
      assert (n_clocks < 10 ||
              low_a == magnitude[16:0] && high_a == magnitude[24:17] && low_b == mu_1 && high_b == mu_1);
    sum_is_exact_and_rounded : assert (n_clocks < 10 || out_friction == rounded);
  end

endmodule
