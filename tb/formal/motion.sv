// Claims of gc_motion about its moves, the time of its records and what it tells the host, for every setpoint, servo and
// recorder: what these give is free. The address of a question holds, as motion_bus claims.
// BEFORE: clocks from a result to its record. BUSY: until that is taken.
module motion #(
    parameter BEFORE = 1,
    parameter BUSY = 1
) (
    input clk,
    input rst,
    input released,
    input move,
    input valid,
    input fetch,
    input [5:0] any_address,
    input [1:0] mode,
    input [31:0] taken
);

  wire busy, ready, refused, answered;
  wire [7:0] moves;
  wire [31:0] count, word;

  // Clocks since the last result; whether a move was refused; moves.
  reg [7:0] since = BUSY, begun = 0;
  reg late = 0;
  // The clock before; clocks for which the question and the oldest record have stayed.
  reg known = 0, fetch_1 = 0, answered_1 = 0, rst_1 = 1, dropped_1 = 0;
  reg [5:0] address_1 = 0;
  reg [31:0] read_1 = 0, word_1 = 0;
  reg [1:0] stays = 0, mode_1 = 0;
  reg none_1 = 0;

  wire [5:0] address = fetch == fetch_1 ? address_1 : any_address;

  gc_motion dut (
      .clk(clk), .rst(rst), .released(released), .in_settings_record_mode(mode), .in_settings_record_taken(taken),
      .in_move(move), .in_fetch_turn(fetch), .in_fetch_address(address), .in_valid(valid), .out_busy(busy),
      .out_state_moves(moves), .out_state_ready(ready), .out_state_refused(refused), .out_state_record_count(count),
      .out_state_fetched(answered), .out_state_word(word)
  );

  (* hierconn *) wire \dut.move_valid , \dut.too_narrow , \dut.records_now , \dut.drops , \dut.triggered ;
  (* hierconn *) wire [4:0] \dut.records ;
  (* hierconn *) wire [31:0] \dut.read_word ;

  always @(posedge clk) begin
    known <= 1;
    since <= valid ? 0 : since < BUSY ? since + 1 : since;
    if (move) {begun, late} <= {begun + 8'd1, !ready};
    {fetch_1, answered_1, rst_1, address_1, read_1} <= {fetch, answered, rst, address, \dut.read_word };
    {word_1, none_1, dropped_1} <= {word, \dut.records == 0, \dut.drops };
    stays <= rst || \dut.drops || (known && (fetch != fetch_1 || address != address_1)) ? 0 : stays == 3 ? 3 : stays + 1;
    mode_1 <= mode;
    if (rst) {since, begun, late, stays, mode_1} <= {8'd0 + BUSY[7:0], 8'd0, 1'b0, 2'd0, 2'd0};
  end

  always @* begin
    moves_only_while_released : assert (!\dut.move_valid || move && released && ready);
    no_move_is_taken_in_silence : assert (moves == begun && (refused || !late && !\dut.too_narrow ));
    record_of_each_result_in_its_time : assert (\dut.records_now == (since == BEFORE));
    busy_until_the_record_is_taken : assert (busy == (since < BUSY));
    no_record_goes_that_is_not_there : assert (!\dut.drops || \dut.records != 0);
    no_record_of_a_fault_goes_before_it : assert (!\dut.drops || \dut.triggered || !(&mode_1));
    answer_is_to_the_question : assert (!known || answered == answered_1 || rst_1 || answered == fetch_1);
    word_is_that_at_its_address :
    assert (!known || rst_1 || word == word_1 || answered != answered_1 && stays >= 2 && word == (none_1 ? 0 : read_1));
    no_word_as_a_record_goes : assert (!known || rst_1 || answered == answered_1 || !dropped_1);
  end

endmodule
