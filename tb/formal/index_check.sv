// Claims of gc_index_check, for every walk, every mark and every period that stays, once there was a homing. MARK_CLOCKS:
// mark_clocks_g. What the registers hold is said too: then the assertions are inductive together.
module index_check #(
    parameter MARK_CLOCKS = 20
) (
    input clk,
    input rst,
    input step_valid,
    input step_up,
    input in_home,
    input any_referenced,
    input in_phase,
    input in_z
);

  wire lost;
  (* anyconst *) reg [31:0] cfg_index_period;
  (* hierconn *) wire [31:0] \dut.last , \dut.residue , \dut.rest ;
  (* hierconn *) wire [2:0] \dut.pins_1 , \dut.pins_2 ;
  (* hierconn *) wire \dut.at_2 , \dut.near_2 , \dut.seen ;
  (* hierconn *) wire [$clog2(MARK_CLOCKS + 1)-1:0] \dut.stay ;

  // The period is known a clock before a homing, and the count refers to the index after one.
  reg started = 0, homed = 0;
  wire in_referenced = any_referenced && homed;

  gc_index_check dut (
      .clk(clk), .rst(rst), .step_valid(step_valid), .step_up(step_up), .in_home(in_home),
      .in_referenced(in_referenced), .in_phase(in_phase), .in_z(in_z), .cfg_index_period(cfg_index_period),
      .out_lost(lost)
  );

  // Counts from the last mark, upwards; a period of 0 is 2**32.
  reg [31:0] behind = 0, period_1 = 0;
  reg referenced_1 = 0, phase_1 = 0, z_1 = 0;
  // One clock later: where that was, and how long it has been there without a mark.
  reg referenced_2 = 0, z_2 = 0, elsewhere_2 = 0, far_2 = 0, at_mark_2 = 0;
  reg [15:0] stay = 0;
  reg seen = 0;
  // What was to be told.
  reg elsewhere = 0, far = 0, missing = 0;

  wire [31:0] up = behind + 1;
  wire [31:0] ahead = period_1 - behind;

  always @(posedge clk) begin
    started <= 1;
    homed <= homed || started && in_home;
    period_1 <= cfg_index_period;
    referenced_1 <= in_referenced;
    phase_1 <= in_phase;
    z_1 <= in_z;
    if (in_home) behind <= 0;
    else if (step_valid) behind <= step_up ? (up == period_1 ? 0 : up) : behind == 0 ? period_1 - 1 : behind - 1;

    referenced_2 <= referenced_1;
    z_2 <= z_1;
    elsewhere_2 <= phase_1 && behind != 0;
    far_2 <= behind > 4 && ahead - 1 > 3;
    at_mark_2 <= phase_1 && behind == 0;

    elsewhere <= referenced_2 && z_2 && elsewhere_2 && !rst;
    far <= referenced_2 && z_2 && far_2 && !rst;
    missing <= referenced_2 && !at_mark_2 && stay >= MARK_CLOCKS && !seen && !rst;
    stay <= referenced_2 && at_mark_2 && !rst ? (&stay ? stay : stay + 1) : 0;
    seen <= referenced_2 && at_mark_2 && !rst && (seen || z_2);
  end

  always @* begin
    mark_elsewhere_is_told : assert (!elsewhere || lost);
    mark_far_away_is_told : assert (!far || lost);
    missing_mark_is_told : assert (!missing || lost);
    nothing_else_is_told : assert (!lost || elsewhere || far || missing);

    period_is_taken : assert (!started || period_1 == cfg_index_period && \dut.last == cfg_index_period - 1);
    reference_follows_a_homing : assert ((!referenced_2 && !referenced_1 || homed) && (!homed || started));
    both_are_counted : assert (!homed || \dut.residue == behind && \dut.rest == ahead - 1);
    pins_are_those :
      assert (\dut.pins_1 == {referenced_1, phase_1, z_1} && \dut.pins_2 [2] == referenced_2 && \dut.pins_2 [0] == z_2);
    place_is_that :
      assert (!referenced_2 || at_mark_2 == (\dut.pins_2 [1] && \dut.at_2 )
              && elsewhere_2 == (\dut.pins_2 [1] && !\dut.at_2 ) && far_2 == !\dut.near_2 );
    stay_is_counted : assert (\dut.stay == (stay < MARK_CLOCKS ? stay : MARK_CLOCKS) && \dut.seen == seen);
  end

endmodule
