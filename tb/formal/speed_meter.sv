// Claims of gc_speed_meter about its speed, for every sequence of counts. TIMEOUT: timeout_g; BITS: of its clock, which
// wraps: ages of edges are compared modulo that.
//
// A timeout of a few clocks, so that a proof has few values of a clock to go through: nothing but the widths of counters
// depends on it. The reference has ages of edges, where the entity has time stamps.
module speed_meter #(
    parameter TIMEOUT = 5,
    parameter BITS = 5
) (
    input clk,
    input rst,
    input step_valid,
    input step_up,
    input step_lost
);

  localparam [31:0] SLOWEST = 32'h7fff_ffff;

  wire valid, zero;
  wire [31:0] period;
  (* hierconn *) wire [BITS-1:0] \dut.now ;
  (* hierconn *) wire [4*BITS-1:0] \dut.stamp ;

  gc_speed_meter dut (
      .clk(clk), .rst(rst), .step_valid(step_valid), .step_up(step_up), .step_lost(step_lost), .speed_valid(valid),
      .speed_zero(zero), .speed_period(period)
  );

  // Clocks since the last edge and the three before it, the last one lowest; since the last one or a lost count; edges
  // in one direction, five at most, and which.
  reg [BITS-1:0] age[1:4];
  reg [$clog2(TIMEOUT+1)-1:0] quiet = 0;
  reg [2:0] n_edges = 0;
  reg up = 0, standstill = 0, step_1 = 0, rst_1 = 1, rst_2 = 1;
  reg [BITS-1:0] since_1 = 0, longest_2 = 0;
  reg five_2 = 0, five_3 = 0, up_2 = 0, up_3 = 0, standstill_2 = 0, standstill_3 = 0;
  reg [BITS-1:0] longest_3 = 0;

  initial {age[1], age[2], age[3], age[4]} = 0;

  always @(posedge clk) begin
    rst_1 <= rst;
    age[1] <= step_valid ? 1 : age[1] + 1;
    age[2] <= (step_valid ? age[1] : age[2]) + 1;
    age[3] <= (step_valid ? age[2] : age[3]) + 1;
    age[4] <= (step_valid ? age[3] : age[4]) + 1;
    since_1 <= age[4];
    step_1 <= step_valid;
    if (step_valid) up <= step_up;
    quiet <= step_valid || step_lost || rst ? 0 : quiet < TIMEOUT - 1 ? quiet + 1 : quiet;
    standstill <= !rst && !step_valid && !step_lost && quiet == TIMEOUT - 1;
    if (rst) n_edges <= 0;
    else if (step_valid) n_edges <= n_edges == 0 || step_up != up ? 1 : n_edges < 5 ? n_edges + 1 : 5;
    else if (step_lost || quiet == TIMEOUT - 1) n_edges <= 0;
    // The period that an edge ended, or longer, as soon as the next one is overdue.
    longest_2 <= step_1 || since_1 > longest_2 ? since_1 : longest_2;
    longest_3 <= longest_2;
    {five_3, five_2} <= rst ? 0 : {five_2, n_edges == 5};
    {up_3, up_2} <= {up_2, up};
    {standstill_3, standstill_2} <= rst ? 0 : {standstill_2, standstill};
  end

  wire signed [31:0] magnitude = longest_3;

  always @* begin
    time_stamps_are_ages :
      assert (\dut.stamp == {\dut.now - age[1], \dut.now - age[2], \dut.now - age[3], \dut.now - age[4]});
    standstill_is_silence : assert (zero == standstill_3);
    valid_is_five_edges_or_standstill : assert (valid == (five_3 || standstill_3));
    period_is_that_of_four_counts : assert (!five_3 || period == (up_3 ? magnitude : -magnitude));
    unknown_is_slowest : assert (five_3 || period == SLOWEST);
    reset_forgets : assert (!rst_1 || !valid && !zero && period == SLOWEST);
  end

endmodule
