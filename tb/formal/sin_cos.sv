// Claims of gc_sin_cos: place and rest make the phase, results are clipped to 18 bits and come in time.
module sin_cos #(
    parameter LATENCY = 7
) (
    input clk,
    input rst,
    input in_valid,
    input [17:0] in_phase
);

  wire out_valid;
  wire [17:0] out_sin, out_cos;
  (* hierconn *) wire [17:0] \dut.rest ;
  (* hierconn *) wire [9:0] \dut.place_1 ;
  (* hierconn *) wire [19:0] \dut.g_result_n1_sum_6 , \dut.g_result_n2_sum_6 ;

  gc_sin_cos dut (
      .clk(clk), .rst(rst), .in_valid(in_valid), .in_phase(in_phase), .out_valid(out_valid), .out_sin(out_sin),
      .out_cos(out_cos)
  );

  // Bit k: a phase came k clocks ago, and no reset since.
  reg [LATENCY:1] taken = 0;
  reg seen = 0;
  reg [17:0] phase, rest;
  reg signed [18:0] sine, cosine;

  always @(posedge clk) begin
    taken <= rst ? 0 : {taken, in_valid};
    seen <= 1;
    phase <= in_phase;
    rest <= \dut.rest ;
    // Without the half LSB.
    sine <= $signed(\dut.g_result_n1_sum_6 ) >>> 1;
    cosine <= $signed(\dut.g_result_n2_sum_6 ) >>> 1;
  end

  wire [17:0] whole = {\dut.place_1 , 8'b0} + rest;
  wire signed [18:0] clipped_sine = sine > 131071 ? 131071 : sine < -131072 ? -131072 : sine;
  wire signed [18:0] clipped_cosine = cosine > 131071 ? 131071 : cosine < -131072 ? -131072 : cosine;

  always @* begin
    none_lost : assert (!taken[LATENCY] || out_valid);
    none_invented : assert (!out_valid || taken[LATENCY]);
    place_and_rest_make_the_phase : assert (!seen || whole == phase);
    rest_is_half_a_place_at_most :
      assert ($signed(\dut.rest ) >= -128 && $signed(\dut.rest ) <= 127);
    results_are_clipped :
      assert (!seen || $signed(out_sin) == clipped_sine && $signed(out_cos) == clipped_cosine);
  end

endmodule
