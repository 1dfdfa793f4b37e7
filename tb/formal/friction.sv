// Claims of gc_friction with both tables, of whatever values: both are cut, so any value may come out of either.
//
// The product is free, too, between its bounds: the magnitude of a force, 2^23 at most, times 18 bits.
module friction (
    input clk,
    input rst,
    input in_valid,
    input [23:0] in_force,
    input [31:0] in_period
);

  wire out_valid;
  wire signed [24:0] out_friction;
  (* hierconn *) wire signed [17:0] \dut.sliding_7 , \dut.g_load_mu_7 ;
  (* hierconn *) wire signed [42:0] \dut.g_load_i_multiply.product ;
  (* hierconn *) wire signed [24:0] \dut.g_load_i_multiply.a_1 ;
  (* hierconn *) wire signed [17:0] \dut.g_load_i_multiply.b_1 ;
  (* hierconn *) wire \dut.valid_3 ;

  gc_friction dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_force(in_force), .in_period(in_period), .out_valid(out_valid),
      .out_friction(out_friction)
  );

  // Clocks ago, of the inputs; of the table's value for the sum of stage 10; of its product.
  reg [10:1] valid_then = 0;
  reg [24*8-1:0] force_then;
  reg [3:0] n_clocks = 0;
  reg signed [17:0] mu_1, sliding_1, sliding_2, sliding_3;
  reg signed [42:0] product_1, product_2;

  always @(posedge clk) begin
    valid_then <= rst ? 0 : {valid_then, in_valid};
    force_then <= {force_then, in_force};
    n_clocks <= n_clocks == 10 ? 10 : n_clocks + 1;
    mu_1 <= \dut.g_load_mu_7 ;
    {sliding_3, sliding_2, sliding_1} <= {sliding_2, sliding_1, \dut.sliding_7 };
    {product_2, product_1} <= {product_1, \dut.g_load_i_multiply.product };
  end

  wire signed [23:0] asked = force_then[24*7+:24];
  wire signed [24:0] magnitude = asked < 0 ? -asked : asked;
  // Both friction forces and half an LSB, in 2^-17 mN.
  wire signed [44:0] sliding = {{10{sliding_3[17]}}, sliding_3, 17'b0};
  wire signed [44:0] sum = sliding + product_2 + 45'sd65536;
  wire signed [44:0] rounded = sum >>> 17;

  always @* begin
    assume (\dut.g_load_i_multiply.product >= -43'sd1099511627776 && \dut.g_load_i_multiply.product <= 43'sd1099511627776);
    comes_after_ten_clocks : assert (out_valid == valid_then[10]);
    place_comes_after_three_clocks : assert (\dut.valid_3 == valid_then[3]);
    load_is_multiplied_by_its_magnitude :
      assert (n_clocks < 9 || \dut.g_load_i_multiply.a_1 == magnitude && \dut.g_load_i_multiply.b_1 == mu_1);
    sum_is_exact_and_rounded : assert (n_clocks < 9 || out_friction == rounded);
  end

endmodule
