// Claims of gc_brake_feedback with two stages, for every behaviour of its inputs.
module brake_feedback (
    input clk,
    input rst,
    input [2:0] brake_fed,
    input [2:0] in_released,
    input [31:0] cfg_clocks
);

  wire [2:0] feedback;
  wire differs, upset;

  gc_brake_feedback dut (
      .clk(clk), .rst(rst), .brake_fed(brake_fed), .in_released(in_released), .cfg_clocks(cfg_clocks),
      .out_feedback(feedback), .out_differs(differs), .upset(upset)
  );

  // Pins, and axes that do not do as told, of the last clocks; clocks since the last reset, at most 4.
  reg [2:0] pins_1 = 0, pins_2 = 0, wrong_1 = 0, wrong_2 = 0, wrong_3 = 0;
  reg limit_was_0 = 0;
  reg [2:0] n_clocks = 0;

  always @(posedge clk) begin
    {pins_1, pins_2} <= {brake_fed, pins_1};
    {wrong_1, wrong_2, wrong_3} <= {brake_fed ^ in_released, wrong_1, wrong_2};
    limit_was_0 <= cfg_clocks == 0;
    n_clocks <= rst ? 0 : n_clocks == 4 ? 4 : n_clocks + 1;
  end

  always @* begin
    pins_are_passed_on : assert (feedback == pins_2);
    brakes_that_obey_do_not_differ : assert (wrong_3 != 0 || !differs);
    brakes_that_do_not_obey_differ : assert (!limit_was_0 || n_clocks < 4 || wrong_3 == 0 || differs);
    none_differs_before_the_pins_are_known : assert (n_clocks >= 3 || !differs);
    nothing_is_upset_of_itself : assert (!upset);
  end

endmodule
