// Claims of gc_edge_watch, for every sequence of steps. Parameters: its generics. What its registers hold is said too:
// then the assertions are inductive together, which is what proves them for numbers too large for a search.
module edge_watch #(
    parameter REVERSAL_CLOCKS = 250,
    parameter SUSPECT_EDGES = 16,
    parameter DITHER_CLOCKS = 40,
    parameter DITHER_EDGES = 64
) (
    input clk,
    input rst,
    input step,
    input step_up,
    input step_illegal
);

  // A step is of one channel or of both.
  wire step_valid = step && !step_illegal;
  wire broken;

  gc_edge_watch dut (
      .clk(clk), .rst(rst), .step_valid(step_valid), .step_up(step_up), .step_illegal(step_illegal), .out_broken(broken)
  );

  localparam CLOCKS_BITS = $clog2(2 * REVERSAL_CLOCKS + 1);
  localparam EDGES_BITS = $clog2(SUSPECT_EDGES + 1);
  localparam RESERVE = DITHER_EDGES * DITHER_CLOCKS;
  localparam RESERVE_BITS = $clog2(RESERVE + DITHER_CLOCKS + 1);

  (* hierconn *) wire \dut.known ;
  (* hierconn *) wire \dut.up_1 ;
  (* hierconn *) wire [CLOCKS_BITS-1:0] \dut.clocks ;
  (* hierconn *) wire \dut.quick ;
  (* hierconn *) wire \dut.suspect ;
  (* hierconn *) wire [EDGES_BITS-1:0] \dut.edges ;
  (* hierconn *) wire [RESERVE_BITS-1:0] \dut.reserve ;

  // Of the last step: whether there was one, its direction, the clocks since, and since the step before it if that was
  // of the other channel.
  reg known = 0, up_1 = 0;
  reg [15:0] since = 0, before = 16'hffff;
  // Since the last edge of the other channel: one that came early, a turn on the spot, edges from that on, and
  // DITHER_CLOCKS for each of the edges in a row that came in half of that time.
  reg early = 0, spot = 0;
  reg [15:0] after = 0, fast = 0;
  reg reversal_1 = 0;

  // A broken wire that was told is forgotten.
  wire reversal = step_valid && known && !broken && step_up != up_1;
  wire on_the_spot = reversal && before < REVERSAL_CLOCKS && since < 2 * REVERSAL_CLOCKS;

  always @(posedge clk) begin
    reversal_1 <= reversal && !rst && !step_illegal;
    since <= step_valid ? 1 : &since ? since : since + 1;
    if (step_valid || broken) begin
      known <= step_valid;
      up_1 <= step_up;
      before <= step_valid && known && !broken && !reversal ? since : 16'hffff;
      early <= reversal && (early || since < DITHER_CLOCKS);
      spot <= reversal && (spot || on_the_spot);
      after <= reversal && (spot || on_the_spot) ? after + 1 : 0;
      fast <= reversal && since <= DITHER_CLOCKS / 2 ? fast + DITHER_CLOCKS : 0;
    end
    if (rst || step_illegal) begin
      known <= 0;
      before <= 16'hffff;
      early <= 0;
      spot <= 0;
      after <= 0;
      fast <= 0;
    end
  end

  always @* begin
    slow_dither_is_never_a_fault : assert (!broken || early || spot);
    broken_only_at_an_edge_of_the_same_channel : assert (!broken || reversal_1);
    turn_on_the_spot_is_found : assert (after < SUSPECT_EDGES || broken);
    fast_edges_are_found : assert (fast < 2 * RESERVE || broken);

    // A broken wire that is told is forgotten, but the checker forgets a clock later. Unless a step is known, the others
    // hold anything.
    known_is_held : assert (\dut.known == (known && !broken) && (!\dut.known || \dut.up_1 == up_1));
    a_step_was_a_clock_ago_at_least : assert (!known || since != 0);
    edges_are_counted_from_a_turn : assert (spot || after == 0);
    fast_edges_follow_a_step : assert (known || fast == 0);
    clocks_are_those_since_the_step : assert (\dut.clocks == (since < 2 * REVERSAL_CLOCKS ? since : 2 * REVERSAL_CLOCKS));
    quick_is_held : assert (!\dut.known || \dut.quick == (before < REVERSAL_CLOCKS));
    suspicion_is_held : assert (!\dut.known || \dut.suspect == spot && \dut.edges == after);
    reserve_is_below_its_end : assert (!\dut.known || \dut.reserve < RESERVE);
    reserve_never_wraps : assert (\dut.reserve < RESERVE + DITHER_CLOCKS);
    slow_edges_leave_no_reserve : assert (!\dut.known || early || \dut.reserve == 0 || \dut.reserve + since <= DITHER_CLOCKS + 1);
    fast_edges_fill_the_reserve : assert (broken || fast == 0 || (fast >> 1) <= \dut.reserve + since - 1);
  end

endmodule
